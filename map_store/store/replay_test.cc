// Tests that the past that a store tells is the map as it was then.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/map_mirror.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using testing::DeterministicOptions;
using testing::MakeRingMap;
using testing::MapMirror;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;
using Views = std::vector<IslandView>;

constexpr char kMission[] = "m";
constexpr uint64_t kNoSnapshots = std::numeric_limits<uint64_t>::max() / 2;

bool Always() { return true; }

class ReplayTest : public ::testing::Test {
 protected:
  ReplayTest() {
    fs::remove_all(folder_);
    MapStore scratch(DeterministicOptions(), nullptr, std::make_unique<InMemoryJournal>(), nullptr);
    TestAgent a(scratch, "scratch", "a", map_a_);
    TestAgent b(scratch, "scratch", "b", map_b_);
    for (int i = 0; i < 14; ++i) {
      batches_.push_back(a.NextBatch(1));
      batches_.push_back(b.NextBatch(1));
    }
  }
  ~ReplayTest() override {
    store_.reset();
    fs::remove_all(folder_);
  }

  void Open(std::unique_ptr<Journal> journal) {
    store_ = std::make_unique<MapStore>(DeterministicOptions(), TheWorld().vocabulary,
                                        std::move(journal), &worker_);
    ASSERT_TRUE(store_->Recover().ok());
  }
  // Opens the store of the folder, perhaps again.
  void OpenOnDisk(uint64_t between_snapshots = kNoSnapshots) {
    store_.reset();
    auto journal = RocksJournal::Open(
        {.directory = folder_.string(), .min_bytes_between_snapshots = between_snapshots});
    ASSERT_TRUE(journal.ok()) << journal.status();
    Open(*std::move(journal));
  }

  uint64_t Begin(const std::string& agent) {
    SessionRequest request;
    request.mission = kMission;
    request.agent = agent;
    return store_->OpenSession(request)->session_id;
  }
  void Fuse() { ASSERT_TRUE(store_->RunFusionUntilIdle(kMission).ok()); }

  // Notes the map when a batch was applied or a revision committed, before more comes. Each batch
  // brings one keyframe.
  void Note() {
    const auto mission = store_->GetMission(kMission);
    if (!mission.ok() || mission->local_maps == 0) return;
    Views views = *store_->GlobalMapView(kMission);
    size_t keyframes = 0;
    for (const IslandView& view : views) keyframes += view.keyframes.size();
    then_.try_emplace({mission->revision, keyframes}, std::move(views));
  }

  // Sends batches [begin, end), and fuses after each fourth.
  void Send(size_t begin, size_t end) {
    const uint64_t a = Begin("a");
    const uint64_t b = Begin("b");
    const auto token = store_->AddMapListener(kMission, [this] { Note(); });
    for (size_t i = begin; i < end; ++i) {
      const bool is_a = batches_[i].local_map == LocalMapId{0xa};
      ASSERT_TRUE(store_->Apply(is_a ? a : b, batches_[i]).ok());
      Note();
      if (i % 4 == 3) Fuse();
    }
    store_->RemoveMapListener(kMission, *token);
    store_->CloseSession(a);
    store_->CloseSession(b);
  }
  // Has people take back what was found, and fusion find it again.
  void Reconsider() {
    const auto token = store_->AddMapListener(kMission, [this] { Note(); });
    const auto accepted = store_->ListOverlaps(kMission, {true, {}}, {});
    ASSERT_FALSE(accepted->items.empty());
    ASSERT_TRUE(store_->RetractOverlap(kMission, accepted->items.front().id, false).ok());
    Fuse();
    ASSERT_TRUE(store_->RederiveGlobalLayer(kMission).ok());
    Fuse();
    store_->RemoveMapListener(kMission, *token);
  }

  // Holds what is told against what was noted. Returns how many moments were told.
  size_t ExpectTruth(const ReplayOptions& options) {
    const auto pieces = store_->ReplayMap(kMission, options, &Always);
    EXPECT_TRUE(pieces.ok()) << pieces.status();
    if (!pieces.ok()) return 0;
    size_t told = 0;
    MapMirror mirror(options.include_points);
    for (const MapChanges& piece : *pieces) {
      mirror.Apply(piece);
      if (piece.continues) continue;
      ++told;
      SCOPED_TRACE(piece.revision);
      const bool is_last = &piece == &pieces->back();
      mirror.ExpectEquals(is_last ? *store_->GlobalMapView(kMission)
                                  : then_.at({piece.revision, mirror.CountKeyframes()}));
    }
    EXPECT_FALSE(pieces->back().continues);
    EXPECT_EQ(pieces->back().revision, store_->GetStatistics(kMission)->revision);
    // Who has been told the past goes on from there.
    MapWatcher watcher(pieces->back().version, options.include_points);
    EXPECT_FALSE(store_->NextChanges(kMission, 1000, watcher)->has_value());
    return told;
  }

  const fs::path folder_ = fs::path(::testing::TempDir()) / "replay_test" /
                           ::testing::UnitTest::GetInstance()->current_test_info()->name();
  SyntheticMap map_a_ = MakeRingMap(0xa, 0, 14);
  SyntheticMap map_b_ = MakeRingMap(0xb, 32, 14);
  TruthfulWorker worker_{{&map_a_, &map_b_}};
  std::vector<MapUpdateBatch> batches_;
  std::map<std::pair<uint64_t, size_t>, Views> then_;  // By revision and number of keyframes.
  std::unique_ptr<MapStore> store_;
};

TEST_F(ReplayTest, TellsEachBatchAndRevisionAsItWas) {
  OpenOnDisk();
  Send(0, batches_.size());
  Reconsider();
  const uint64_t revisions = store_->GetStatistics(kMission)->revision;
  ASSERT_GE(revisions, 6u);
  EXPECT_EQ(then_.size(), batches_.size() + revisions);
  EXPECT_EQ(ExpectTruth({.include_points = true}), then_.size());
  EXPECT_EQ(ExpectTruth({.include_points = false}), then_.size());
  // A store that has read its journal again tells the same.
  OpenOnDisk();
  EXPECT_EQ(ExpectTruth({.include_points = true}), then_.size());
}

TEST_F(ReplayTest, OfManyMomentsSomeAreTold) {
  OpenOnDisk();
  Send(0, batches_.size());
  Reconsider();
  EXPECT_EQ(ExpectTruth({.include_points = true, .max_moments = 4}), 4u);
  EXPECT_EQ(ExpectTruth({.include_points = true, .max_moments = 2}), 2u);
}

TEST_F(ReplayTest, BeginsWithTheSnapshot) {
  OpenOnDisk();
  Send(0, 20);
  OpenOnDisk(/*between_snapshots=*/1);
  Fuse();
  const uint64_t revision = store_->GetStatistics(kMission)->revision;
  then_.clear();
  Note();
  OpenOnDisk();
  EXPECT_EQ(ExpectTruth({.include_points = true}), 2u) << "the snapshot, and the present";
  Send(20, batches_.size());
  Reconsider();
  ASSERT_GE(store_->GetStatistics(kMission)->revision, revision + 3);
  EXPECT_EQ(ExpectTruth({.include_points = true}), then_.size());
  EXPECT_EQ(ExpectTruth({.include_points = true, .max_moments = 3}), 3u);
}

TEST_F(ReplayTest, AJournalThatKeepsNothingTellsThePresent) {
  Open(std::make_unique<InMemoryJournal>());
  Send(0, batches_.size());
  EXPECT_EQ(ExpectTruth({.include_points = true}), 1u);
}

TEST_F(ReplayTest, EndsWhenItIsTooLongOrNobodyWaits) {
  OpenOnDisk();
  Send(0, 12);
  const auto too_long =
      store_->ReplayMap(kMission, {.include_points = true, .max_bytes = 3000}, &Always);
  EXPECT_TRUE(absl::IsResourceExhausted(too_long.status())) << too_long.status();
  EXPECT_THAT(std::string(too_long.status().message()),
              ::testing::StartsWith("the replay is longer than 3000 bytes"));
  int asked = 0;
  const auto given_up = store_->ReplayMap(kMission, {}, [&asked] { return ++asked < 5; });
  EXPECT_TRUE(absl::IsCancelled(given_up.status())) << given_up.status();
  EXPECT_EQ(asked, 5);
  EXPECT_TRUE(
      absl::IsInvalidArgument(store_->ReplayMap(kMission, {.max_moments = 1}, &Always).status()));
  EXPECT_TRUE(absl::IsNotFound(store_->ReplayMap("nobodys", {}, &Always).status()));
}

TEST_F(ReplayTest, EndsWhenTheMissionIsDeleted) {
  OpenOnDisk();
  Send(0, 12);
  bool begun = false;
  std::thread deletion;
  const auto past = store_->ReplayMap(kMission, {}, [&] {
    if (!std::exchange(begun, true)) {
      deletion = std::thread([this] { ASSERT_TRUE(store_->DeleteMission(kMission).ok()); });
      // The deletion waits for the end of the replay.
      absl::SleepFor(absl::Milliseconds(100));
    }
    return true;
  });
  deletion.join();
  EXPECT_TRUE(absl::IsNotFound(past.status())) << past.status();
}

}  // namespace
}  // namespace corbslam::map_store
