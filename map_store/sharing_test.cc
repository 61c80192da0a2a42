// The map comes back: what agents are sent after fusion, and no more than that.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <set>

#include "map_store/map_store.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam {
namespace {

using testing::DeterministicOptions;
using testing::MakeRingMap;
using testing::SharedMirror;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;

constexpr char kMission[] = "m";

class SharingTest : public ::testing::Test {
 protected:
  void Fuse() { ASSERT_TRUE(store_.RunFusionUntilIdle(kMission).ok()); }
  Similarity3d Pose(KeyframeId id) { return store_.GetKeyframe(kMission, id)->camera_from_island; }
  // The mirror holds what it needs, and where the store says it is.
  void ExpectSound(const TestAgent& agent) {
    const SharedMirror& mirror = agent.mirror();
    for (const auto& [id, keyframe] : mirror.keyframes) {
      EXPECT_NE(id.local_map, agent.local_map());
      EXPECT_LT((keyframe.camera_from_global.translation - Pose(id).translation).norm(), 1e-4);
      for (const MapPointId& point : keyframe.points) {
        if (!point.IsValid() || point.local_map == agent.local_map()) continue;
        EXPECT_TRUE(mirror.points.contains(point)) << ToString(id) << " " << ToString(point);
      }
    }
    for (const auto& [id, pose] : mirror.own) {
      EXPECT_EQ(id.local_map, agent.local_map());
      EXPECT_LT((pose.translation - Pose(id).translation).norm(), 1e-4);
    }
  }

  SyntheticMap map_a_ = MakeRingMap(0xa, 0, 14);
  SyntheticMap map_b_ = MakeRingMap(0xb, 32, 14);
  SyntheticMap map_c_ = MakeRingMap(0xc, 64, 14);
  TruthfulWorker worker_{{&map_a_, &map_b_, &map_c_}};
  MapStore store_{DeterministicOptions(), TheWorld().vocabulary,
                  std::make_unique<InMemoryJournal>(), &worker_};
};

TEST_F(SharingTest, NothingBeforeFusionEverythingSettledAfterIt) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  ASSERT_TRUE(a.TakeShared().ok());
  EXPECT_EQ(a.mirror().updates, 0);
  Fuse();
  ASSERT_TRUE(a.TakeShared().ok());
  ASSERT_TRUE(b.TakeShared().ok());
  EXPECT_EQ(a.mirror().keyframes.size(), 11u);
  EXPECT_EQ(b.mirror().keyframes.size(), 11u);
  EXPECT_EQ(a.mirror().own.size(), 11u);
  EXPECT_EQ(b.mirror().own.size(), 11u);
  EXPECT_EQ(a.mirror().revision, store_.GetStatistics(kMission)->revision);
  ExpectSound(a);
  ExpectSound(b);
  // B learns which of its own points are A's.
  size_t own_members = 0;
  for (const auto& [survivor, members] : b.mirror().landmarks) {
    for (const MapPointId& member : members) {
      if (member.local_map == b.local_map()) ++own_members;
    }
  }
  EXPECT_GT(own_members, 20u);
  // Then there is nothing more to say.
  const int updates = b.mirror().updates;
  ASSERT_TRUE(b.TakeShared().ok());
  EXPECT_EQ(b.mirror().updates, updates);
}

TEST_F(SharingTest, AnAgentThatComesLaterGetsTheMapOfOneThatHasGone) {
  TestAgent a(store_, kMission, "a", map_a_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(a.Close().ok());
  store_.CloseSession(a.session());
  Fuse();
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(b.Stream(5).ok());
  Fuse();
  ASSERT_TRUE(b.TakeShared().ok());
  EXPECT_EQ(b.mirror().keyframes.size(), 14u);
  ExpectSound(b);
}

TEST_F(SharingTest, ASmallBudgetTakesMoreStepsToTheSameEndNearestFirst) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  std::vector<KeyframeId> order;
  size_t updates = 0;
  while (true) {
    const auto update = store_.NextShared(b.session(), 10000);
    ASSERT_TRUE(update.ok());
    if (!update->has_value()) break;
    ASSERT_LT(++updates, 1000u);
    EXPECT_LE((*update)->keyframes.size(), 1u);
    for (const SharedKeyframe& keyframe : (*update)->keyframes) {
      order.push_back(keyframe.payload->id);
    }
  }
  EXPECT_GT(updates, 11u);
  ASSERT_EQ(order.size(), 11u);
  EXPECT_EQ(std::set<KeyframeId>(order.begin(), order.end()).size(), 11u);
  // B's ground is at A's end.
  EXPECT_GT(order.front().index, 5u);
  EXPECT_LT(order.back().index, 5u);
}

TEST_F(SharingTest, LaterStepsCarryOnlyWhatChanged) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  ASSERT_TRUE(b.TakeShared().ok());
  MapUpdateBatch removal = a.EmptyBatch();
  removal.removed_keyframes.push_back({a.Id(4), a.Id(3), Rigid3d::Identity()});
  const MapPointId point = map_a_.map.points().begin()->first;
  removal.removed_points.push_back(point);
  ASSERT_TRUE(a.Send(removal).ok());
  auto update = store_.NextShared(b.session(), 1 << 20);
  ASSERT_TRUE(update.ok() && update->has_value());
  EXPECT_TRUE((*update)->keyframes.empty());
  EXPECT_THAT((*update)->removed_keyframes, ::testing::ElementsAre(a.Id(4)));
  EXPECT_THAT((*update)->removed_points, ::testing::ElementsAre(point));

  ASSERT_TRUE(a.Close().ok());
  ASSERT_TRUE(b.Close().ok());
  Fuse();
  update = store_.NextShared(b.session(), 1 << 20);
  ASSERT_TRUE(update.ok() && update->has_value());
  // Only those that have settled since; none that b holds.
  for (const SharedKeyframe& keyframe : (*update)->keyframes) {
    EXPECT_GT(keyframe.payload->id.index, 10u);
  }
  EXPECT_GT((*update)->own_keyframes.size(), 0u);
}

TEST_F(SharingTest, AnotherFrameStartsAgain) {
  // B and C meet first, in B's frame; then A, who was first in the mission, meets B.
  TestAgent a(store_, kMission, "a", map_a_);
  ASSERT_TRUE(a.Stream(4).ok());
  TestAgent b(store_, kMission, "b", map_b_);
  TestAgent c(store_, kMission, "c", map_c_);
  ASSERT_TRUE(b.Stream().ok());
  ASSERT_TRUE(c.Stream().ok());
  Fuse();
  ASSERT_EQ(store_.GetStatistics(kMission)->islands, 2u);
  ASSERT_TRUE(c.TakeShared().ok());
  EXPECT_FALSE(c.mirror().keyframes.empty());
  EXPECT_EQ(c.mirror().restarts, 0);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(a.Close().ok());
  Fuse();
  ASSERT_EQ(store_.GetStatistics(kMission)->islands, 1u);
  ASSERT_TRUE(c.TakeShared().ok());
  EXPECT_EQ(c.mirror().restarts, 1);
  EXPECT_EQ(c.mirror().keyframes.size(), 14u + 11u);
  ExpectSound(c);
}

TEST_F(SharingTest, AResumedSessionGoesOnOrStartsAgain) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  ASSERT_TRUE(b.TakeShared(100 << 20).ok());
  SessionRequest request;
  request.mission = kMission;
  request.agent = "b";
  request.last_revision = b.mirror().revision;
  const auto certain = store_.OpenSession(request);
  EXPECT_FALSE(store_.NextShared(certain->session_id, 1 << 20)->has_value());
  request.last_revision = b.mirror().revision - 1;
  const auto behind = store_.OpenSession(request);
  const auto update = store_.NextShared(behind->session_id, 1 << 20);
  ASSERT_TRUE(update->has_value());
  EXPECT_TRUE((*update)->restart);
  EXPECT_FALSE((*update)->keyframes.empty());
}

// What stands for a replaced point may take the next one off the list of what the agent holds.
TEST_F(SharingTest, ReplacedPointsGoOnAsTheirLandmarks) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  TestAgent c(store_, kMission, "c", map_c_);
  for (TestAgent* agent : {&a, &b, &c}) {
    ASSERT_TRUE(agent->Stream().ok());
    ASSERT_TRUE(agent->Close().ok());
  }
  Fuse();
  ASSERT_TRUE(c.TakeShared().ok());
  std::vector<MapPointId> held;
  for (const auto& [id, point] : c.mirror().points) {
    if (id.local_map == a.local_map()) held.push_back(id);
  }
  ASSERT_GT(held.size(), 20u);
  MapUpdateBatch batch = a.EmptyBatch();
  for (size_t i = 0; i + 1 < held.size(); i += 2) {
    batch.replacements.push_back({held[i], held[i + 1]});
  }
  ASSERT_TRUE(a.Send(batch).ok());
  Fuse();
  ASSERT_TRUE(c.TakeShared().ok());
  ExpectSound(c);
  const int updates = c.mirror().updates;
  ASSERT_TRUE(c.TakeShared().ok());
  EXPECT_EQ(c.mirror().updates, updates);
}

TEST_F(SharingTest, ListenersHearOfARevision) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  int calls = 0;
  // It may call the store.
  store_.SetSharedListener(a.session(), [&] {
    ++calls;
    EXPECT_TRUE(a.TakeShared().ok());
  });
  ASSERT_TRUE(a.Stream().ok());
  EXPECT_EQ(calls, 0) << "its own batches are no news";
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  EXPECT_GT(calls, 0);
  EXPECT_EQ(a.mirror().keyframes.size(), 11u);
}

}  // namespace
}  // namespace corbslam
