// Tests views that are read in pieces, between which robots go on.
#include "map_store/view/long_read.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "map_store/fusion/fusion_job.h"
#include "map_store/records/record_application.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"
#include "map_store/view/island_view.h"

namespace corbslam::map_store {
namespace {

using testing::DeterministicOptions;
using testing::MakeRingMap;
using testing::MeanReprojectionError_px2;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;

constexpr char kMission[] = "m";
constexpr int kStreamed = 12;

// A read with an event at each pause, one after the other.
class EventfulRead : public LongRead {
 public:
  explicit EventfulRead(std::vector<std::function<void()>> events) : events_(std::move(events)) {}
  absl::Status Pause() override {
    if (!events_.empty()) events_[pauses_ % events_.size()]();
    ++pauses_;
    return absl::OkStatus();
  }
  size_t pauses() const { return pauses_; }

 private:
  const std::vector<std::function<void()>> events_;
  size_t pauses_ = 0;
};

class RefusingRead : public LongRead {
 public:
  absl::Status Pause() override { return absl::AbortedError("stop"); }
};

// Two robots' fused maps, and what the robots say next.
class LongReadTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(a_.Stream(kStreamed).ok());
    ASSERT_TRUE(b_.Stream(kStreamed).ok());
    ASSERT_TRUE(store_.RunFusionUntilIdle(kMission).ok());
    ASSERT_EQ(store_.GetStatistics(kMission)->islands, 1u);
    auto backup = store_.BackUpMission(kMission);
    ASSERT_TRUE(backup.ok());
    MissionRestorer restorer = store_.StartRestoring();
    for (std::string piece = backup->Next(1 << 20); !piece.empty(); piece = backup->Next(1 << 20)) {
      ASSERT_TRUE(restorer.Add(piece).ok());
    }
    auto state = restorer.Finish();
    ASSERT_TRUE(state.ok()) << state.status();
    state_ = *std::move(state);
    RestoreWords(TheWorld().vocabulary.get(), state_);
  }

  const Island& island() const { return state_.global.islands.begin()->second; }

  void Apply(const MapUpdateBatch& batch, const char* agent) {
    const BatchWords words = ComputeWords(batch, TheWorld().vocabulary.get());
    map_store::Apply(BatchRecord{agent, std::make_shared<MapUpdateBatch>(batch), absl::Time()},
                     words, options_, state_);
  }

  void AddKeyframe() { Apply(a_.NextBatch(1), "a"); }

  void RemoveKeyframe() {
    const Map& map = state_.FindLocalMap(b_.local_map())->map;
    const KeyframeId id = b_.Id(next_removed_++);
    const Keyframe& keyframe = *map.FindKeyframe(id);
    const Rigid3d& parent = map.FindKeyframe(keyframe.parent)->camera_from_map;
    MapUpdateBatch batch = b_.EmptyBatch();
    batch.removed_keyframes = {{id, keyframe.parent, parent * keyframe.camera_from_map.Inverse()}};
    Apply(batch, "b");
  }

  void RemovePoints() {
    MapUpdateBatch batch = b_.EmptyBatch();
    for (const auto& [id, point] : state_.FindLocalMap(b_.local_map())->map.points()) {
      if (batch.removed_points.size() == 40) break;
      batch.removed_points.push_back(id);
    }
    Apply(batch, "b");
  }

  // Moves all keyframes, as a robot does whose own frame is another after a loop.
  void MoveAll() {
    const Rigid3d moved_from_map = {
        Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY())), {1, 0.2, -2}};
    MapUpdateBatch batch = a_.EmptyBatch();
    const Map& map = state_.FindLocalMap(a_.local_map())->map;
    for (const auto& [id, keyframe] : map.keyframes()) {
      batch.light_keyframes.push_back(
          {id, keyframe.camera_from_map * moved_from_map.Inverse(), keyframe.parent});
    }
    for (const auto& [id, point] : map.points()) {
      batch.light_points.push_back({id, moved_from_map * point.position_in_map});
    }
    Apply(batch, "a");
  }

  EventfulRead BusyRobots() {
    return EventfulRead({[this] { AddKeyframe(); }, [this] { RemoveKeyframe(); },
                         [this] { MoveAll(); }, [this] { RemovePoints(); }});
  }

  SyntheticMap map_a_ = MakeRingMap(0xa, 0, 40);
  SyntheticMap map_b_ = MakeRingMap(0xb, 24, 20);
  TruthfulWorker worker_{{&map_a_, &map_b_}};
  const MapStoreOptions options_ = DeterministicOptions();
  MapStore store_{options_, TheWorld().vocabulary, std::make_unique<InMemoryJournal>(), &worker_};
  TestAgent a_{store_, kMission, "a", map_a_};
  TestAgent b_{store_, kMission, "b", map_b_};
  MissionState state_;
  QueryViews views_;
  uint32_t next_removed_ = 3;
};

void ExpectSameViews(const Map& one, const Map& other) {
  ASSERT_EQ(one.keyframes().size(), other.keyframes().size());
  for (const auto& [id, keyframe] : one.keyframes()) {
    EXPECT_EQ(keyframe.points, other.FindKeyframe(id)->points) << ToString(id);
    EXPECT_EQ(keyframe.covisible, other.FindKeyframe(id)->covisible) << ToString(id);
  }
  ASSERT_EQ(one.points().size(), other.points().size());
  for (const auto& [id, point] : one.points()) {
    EXPECT_EQ(point.position_in_map, other.FindPoint(id)->position_in_map) << ToString(id);
  }
}

TEST_F(LongReadTest, PausesWithoutNewsChangeNothing) {
  UnbrokenRead unbroken;
  EventfulRead paused({});
  const std::set<KeyframeId> centres = {a_.Id(9), b_.Id(3)};
  const auto whole = [&](LongRead& read) {
    return TakeWholeSnapshot(state_, island(), {}, Rejected::kTryAgain, read).value().view;
  };
  const auto graph = [&](LongRead& read) {
    return TakeGraphSnapshot(state_, island(), {}, centres, 5, {}, read).value().view;
  };
  ExpectSameViews(whole(unbroken), whole(paused));
  EXPECT_GE(paused.pauses(), 2u);
  ExpectSameViews(graph(unbroken), graph(paused));
  EXPECT_GE(paused.pauses(), 4u);
}

TEST_F(LongReadTest, AWholeViewFitsTogetherWhateverRobotsDoMeanwhile) {
  UnbrokenRead unbroken;
  const IslandSnapshot before =
      TakeWholeSnapshot(state_, island(), {}, Rejected::kTryAgain, unbroken).value();
  EventfulRead busy = BusyRobots();
  const auto during = TakeWholeSnapshot(state_, island(), {}, Rejected::kTryAgain, busy);
  ASSERT_TRUE(during.ok()) << during.status();
  EXPECT_GE(busy.pauses(), 2u);
  EXPECT_EQ(during->view.keyframes().size(), before.view.keyframes().size());
  EXPECT_LT(MeanReprojectionError_px2(during->view), 1.1 * MeanReprojectionError_px2(before.view));
}

TEST_F(LongReadTest, AGraphFitsTogetherWhateverRobotsDoMeanwhile) {
  UnbrokenRead unbroken;
  const std::set<KeyframeId> centres = {a_.Id(4), a_.Id(9), b_.Id(1), b_.Id(8)};
  const IslandSnapshot before =
      TakeGraphSnapshot(state_, island(), {}, centres, 10, {}, unbroken).value();
  EventfulRead busy = BusyRobots();
  const auto during = TakeGraphSnapshot(state_, island(), {}, centres, 10, {}, busy);
  ASSERT_TRUE(during.ok()) << during.status();
  EXPECT_GE(busy.pauses(), 3u);
  EXPECT_EQ(during->view.keyframes().size(), before.view.keyframes().size());
  EXPECT_LT(MeanReprojectionError_px2(during->view), 1.1 * MeanReprojectionError_px2(before.view));
}

TEST_F(LongReadTest, ARequestWhoseKeyframeWentIsMadeAgain) {
  const auto next_query = [this] {
    state_.queries.Clear();
    state_.queries.Push(b_.Id(2), {a_.local_map()});
  };
  next_query();
  // The overlaps are forgotten, so that the place is looked up again.
  state_.global.overlaps = OverlapLedger();
  state_.global.landmarks = Landmarks();
  FusionAction query;
  query.kind = FusionAction::Kind::kQuery;
  UnbrokenRead unbroken;
  const auto undisturbed = PrepareRequest(state_, query, options_, unbroken, views_);
  ASSERT_TRUE(undisturbed.ok() && undisturbed->has_value());
  next_removed_ = 2;
  EventfulRead removal({[this] {
    if (next_removed_ == 2) RemoveKeyframe();
  }});
  EXPECT_EQ(PrepareRequest(state_, query, options_, removal, views_).status().code(),
            absl::StatusCode::kAborted);
  EXPECT_FALSE(PrepareRequest(state_, query, options_, unbroken, views_)->has_value());
}

TEST_F(LongReadTest, WhoeverIsNotWantedAnyMoreStops) {
  RefusingRead refusing;
  FusionAction adjust;
  adjust.kind = FusionAction::Kind::kAdjust;
  adjust.target = island().id;
  EXPECT_EQ(PrepareRequest(state_, adjust, options_, refusing, views_).status().code(),
            absl::StatusCode::kAborted);
}

}  // namespace
}  // namespace corbslam::map_store
