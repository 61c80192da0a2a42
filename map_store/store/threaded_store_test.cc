// Tests the store with its own threads: streams, fusion, look-ups and sharing at once; a worker
// that is away; an end in the middle of work.
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <variant>

#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam::map_store {
namespace {

using testing::MakeRingMap;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;

constexpr char kMission[] = "m";

class ThreadedStoreTest : public ::testing::Test {
 protected:
  static MapStoreOptions Options() {
    MapStoreOptions options;
    options.settle_after = 3;
    options.retry_ms = 1;
    return options;
  }
  std::unique_ptr<MapStore> MakeStore() {
    return std::make_unique<MapStore>(Options(), TheWorld().vocabulary,
                                      std::make_unique<InMemoryJournal>(), &worker_);
  }

  SyntheticMap map_a_ = MakeRingMap(0xa, 0, 14);
  SyntheticMap map_b_ = MakeRingMap(0xb, 32, 14);
  TruthfulWorker worker_{{&map_a_, &map_b_}};
};

TEST_F(ThreadedStoreTest, TwoStreamsAtOnceBecomeOneIsland) {
  const auto store = MakeStore();
  TestAgent a(*store, kMission, "a", map_a_);
  TestAgent b(*store, kMission, "b", map_b_);
  std::atomic<bool> done = false;
  uint64_t events = 0;
  std::thread reader([&] {
    while (!done) {
      EXPECT_TRUE(store->GlobalMapView(kMission).ok());
      EXPECT_TRUE(store->ReplayMap(kMission, {}, [] { return true; }).ok());
      while (const auto event = *store->EventAfter(kMission, events)) {
        EXPECT_EQ(event->number, ++events);
      }
      EXPECT_TRUE(store->GetTrajectory(kMission, "", TrajectoryFrame::kGlobal).ok());
      EXPECT_TRUE(store->GetMission(kMission).ok());
    }
  });
  const auto stream = [](TestAgent& agent) {
    for (int k = 0; k < 14; ++k) {
      EXPECT_TRUE(agent.Stream(1).ok());
      EXPECT_TRUE(agent.TakeShared().ok());
    }
    EXPECT_TRUE(agent.Close().ok());
  };
  std::thread first([&] { stream(a); });
  std::thread second([&] { stream(b); });
  first.join();
  second.join();
  EXPECT_TRUE(store->WaitUntilFusionIdle(kMission, absl::Seconds(30)).ok());
  done = true;
  reader.join();
  EXPECT_GE(events, 4u) << "both came, and began a local map";
  EXPECT_EQ(store->GetStatistics(kMission)->islands, 1u);
  EXPECT_EQ(store->GetStatistics(kMission)->keyframes, 28u);
  EXPECT_TRUE(*store->IsFusionIdle(kMission));
  EXPECT_TRUE(b.TakeShared().ok());
  EXPECT_EQ(b.mirror().keyframes.size(), 14u);
}

// A mission whose adjustment takes for ever keeps no other from its own.
TEST_F(ThreadedStoreTest, MissionsShareTheWorkers) {
  absl::Notification let_go;
  std::atomic<int> adjusting = 0;
  worker_.during_adjust = [&](const ProgressCallback&) {
    if (adjusting++ == 0) let_go.WaitForNotification();
    return true;
  };
  MapStoreOptions options = Options();
  options.fusion_threads = 2;
  MapStore store(options, TheWorld().vocabulary, std::make_unique<InMemoryJournal>(), &worker_);
  const auto fuse = [&](const std::string& mission) {
    TestAgent a(store, mission, "a", map_a_);
    TestAgent b(store, mission, "b", map_b_);
    for (TestAgent* agent : {&a, &b}) {
      ASSERT_TRUE(agent->Stream().ok());
      ASSERT_TRUE(agent->Close().ok());
    }
  };
  ASSERT_NO_FATAL_FAILURE(fuse("slow"));
  while (adjusting == 0) absl::SleepFor(absl::Milliseconds(1));
  ASSERT_NO_FATAL_FAILURE(fuse("quick"));
  EXPECT_TRUE(store.WaitUntilFusionIdle("quick", absl::Seconds(30)).ok());
  EXPECT_EQ(store.GetStatistics("quick")->islands, 1u);
  EXPECT_FALSE(*store.IsFusionIdle("slow"));
  let_go.Notify();
  EXPECT_TRUE(store.WaitUntilFusionIdle("slow", absl::Seconds(30)).ok());
}

TEST_F(ThreadedStoreTest, WaitsForAWorkerThatIsAway) {
  worker_.verify_failures.assign(7, absl::UnavailableError("no worker"));
  worker_.fuse_failures.assign(7, absl::UnavailableError("no worker"));
  const auto store = MakeStore();
  TestAgent a(*store, kMission, "a", map_a_);
  TestAgent b(*store, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  EXPECT_TRUE(store->WaitUntilFusionIdle(kMission, absl::Seconds(30)).ok());
  EXPECT_EQ(store->GetStatistics(kMission)->islands, 1u);
  EXPECT_EQ(store->GetStatistics(kMission)->failed_requests, 0u);
}

// A journal that takes batches, but refuses the first few records of other kinds.
class NarrowJournal : public InMemoryJournal {
 public:
  absl::StatusOr<Position> Append(absl::string_view mission, const JournalRecord& record) override {
    const bool is_batch = std::holds_alternative<BatchRecord>(record);
    if (!is_batch && refusals_-- > 0) return absl::ResourceExhaustedError("no room");
    return InMemoryJournal::Append(mission, record);
  }

 private:
  std::atomic<int> refusals_ = 9;
};

TEST_F(ThreadedStoreTest, AJournalWithoutRoomIsNoReasonToGiveUpAnOverlap) {
  const auto store = std::make_unique<MapStore>(Options(), TheWorld().vocabulary,
                                                std::make_unique<NarrowJournal>(), &worker_);
  TestAgent a(*store, kMission, "a", map_a_);
  TestAgent b(*store, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  EXPECT_TRUE(store->WaitUntilFusionIdle(kMission, absl::Seconds(30)).ok());
  EXPECT_EQ(store->GetStatistics(kMission)->islands, 1u);
  EXPECT_EQ(store->GetStatistics(kMission)->failed_requests, 0u);
}

TEST_F(ThreadedStoreTest, WhatAJournalRefusesIsNotComputedAnew) {
  std::atomic<int> verified = 0;
  worker_.during_verify = [&] { ++verified; };
  const auto fuse = [&](std::unique_ptr<Journal> journal) {
    verified = 0;
    MapStore store(Options(), TheWorld().vocabulary, std::move(journal), &worker_);
    TestAgent a(store, kMission, "a", map_a_);
    TestAgent b(store, kMission, "b", map_b_);
    EXPECT_TRUE(a.Stream().ok());
    EXPECT_TRUE(a.Close().ok());
    EXPECT_TRUE(store.WaitUntilFusionIdle(kMission, absl::Seconds(30)).ok());
    // One request, so that how often it is asked does not depend on what came when.
    EXPECT_TRUE(b.Stream(5).ok());
    EXPECT_TRUE(store.WaitUntilFusionIdle(kMission, absl::Seconds(30)).ok());
    EXPECT_GT(store.GetStatistics(kMission)->overlaps_queried, 0u);
    return verified.load();
  };
  const int wanted = fuse(std::make_unique<InMemoryJournal>());
  EXPECT_EQ(fuse(std::make_unique<NarrowJournal>()), wanted);
}

// A journal in which one mission is damaged: it takes that one's batches no more than its results.
class DamagedJournal : public InMemoryJournal {
 public:
  absl::Status Damage(absl::string_view mission) const override {
    return is_damaged && mission == kMission ? absl::DataLossError("000007.sst") : absl::OkStatus();
  }
  absl::StatusOr<Position> Append(absl::string_view mission, const JournalRecord& record) override {
    if (const absl::Status damage = Damage(mission); !damage.ok()) return damage;
    return InMemoryJournal::Append(mission, record);
  }
  std::atomic<bool> is_damaged = false;
};

TEST_F(ThreadedStoreTest, ADamagedMissionHoldsNoOtherOneUp) {
  auto journal = std::make_unique<DamagedJournal>();
  DamagedJournal& damaged = *journal;
  std::atomic<bool> breaks = true;
  std::atomic<int> asked_after = 0;
  // It breaks while a worker computes for it.
  worker_.during_verify = [&] {
    if (damaged.is_damaged) ++asked_after;
    if (breaks) damaged.is_damaged = true;
  };
  MapStoreOptions options = Options();
  // A lane that paused once would not go on within this test.
  options.retry_ms = 600'000;
  MapStore store(options, TheWorld().vocabulary, std::move(journal), &worker_);
  TestAgent a(store, kMission, "a", map_a_);
  TestAgent b(store, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  static_cast<void>(b.Stream());
  EXPECT_TRUE(store.WaitUntilFusionIdle(kMission, absl::Seconds(30)).ok());
  EXPECT_TRUE(damaged.is_damaged);
  EXPECT_EQ(asked_after, 0);
  breaks = false;
  TestAgent c(store, "other", "a", map_a_);
  TestAgent d(store, "other", "b", map_b_);
  ASSERT_TRUE(c.Stream().ok());
  ASSERT_TRUE(d.Stream().ok());
  EXPECT_TRUE(store.WaitUntilFusionIdle("other", absl::Seconds(30)).ok());
  EXPECT_EQ(store.GetStatistics("other")->islands, 1u);
}

TEST_F(ThreadedStoreTest, IngestionDoesNotWaitForAdjustmentAndTheEndCancelsIt) {
  absl::Notification adjusting;
  worker_.during_adjust = [&](const ProgressCallback& progress) {
    if (!adjusting.HasBeenNotified()) adjusting.Notify();
    // The adjustment never ends by itself.
    while (progress(0.5)) absl::SleepFor(absl::Milliseconds(1));
    return false;
  };
  auto store = MakeStore();
  TestAgent a(*store, kMission, "a", map_a_);
  TestAgent b(*store, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream(10).ok());
  ASSERT_TRUE(adjusting.WaitForNotificationWithTimeout(absl::Seconds(30)));
  EXPECT_TRUE(b.Stream().ok());
  EXPECT_EQ(store->GetStatistics(kMission)->keyframes, 28u);
  EXPECT_EQ(store->WaitUntilFusionIdle(kMission, absl::Milliseconds(1)).code(),
            absl::StatusCode::kDeadlineExceeded);
  store.reset();
}

// Each loop that a robot closes is welded, which cancels the adjustment that runs.
TEST_F(ThreadedStoreTest, LoopsInARowCancelTwoAdjustmentsAndWaitForTheThird) {
  std::atomic<int> begun = 0;
  std::atomic<int> cancelled = 0;
  absl::Notification let_go;
  worker_.during_adjust = [&](const ProgressCallback& progress) {
    ++begun;
    while (progress(0.5)) {
      if (let_go.HasBeenNotified()) return true;
      absl::SleepFor(absl::Milliseconds(1));
    }
    ++cancelled;
    return false;
  };
  const auto store = MakeStore();
  TestAgent a(*store, kMission, "a", map_a_);
  TestAgent b(*store, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  const auto close_loop = [&](uint32_t end) {
    MapUpdateBatch loop = b.EmptyBatch();
    loop.loop_edges.push_back({b.Id(13), b.Id(end), Similarity3d()});
    EXPECT_TRUE(b.Send(loop).ok());
  };
  const auto until = [](const std::atomic<int>& count, int wanted) {
    for (int i = 0; i < 30'000 && count < wanted; ++i) absl::SleepFor(absl::Milliseconds(1));
    return count == wanted;
  };
  ASSERT_TRUE(until(begun, 1));
  for (int i = 1; i <= 2; ++i) {
    close_loop(static_cast<uint32_t>(i));
    ASSERT_TRUE(until(cancelled, i));
    ASSERT_TRUE(until(begun, i + 1));
  }
  const size_t fused = worker_.fused().size();
  close_loop(3);
  // The test waits long enough for a welding.
  absl::SleepFor(absl::Milliseconds(200));
  EXPECT_EQ(worker_.fused().size(), fused);
  EXPECT_EQ(cancelled, 2);
  let_go.Notify();
  EXPECT_TRUE(store->WaitUntilFusionIdle(kMission, absl::Seconds(30)).ok());
  EXPECT_GT(worker_.fused().size(), fused);
  EXPECT_EQ(cancelled, 2);
  EXPECT_GT(begun, 3);
}

TEST_F(ThreadedStoreTest, DeletingAMissionEndsItsWork) {
  absl::Notification adjusting;
  worker_.during_adjust = [&](const ProgressCallback& progress) {
    if (!adjusting.HasBeenNotified()) adjusting.Notify();
    while (progress(0.5)) absl::SleepFor(absl::Milliseconds(1));
    return false;
  };
  const auto store = MakeStore();
  TestAgent a(*store, kMission, "a", map_a_);
  TestAgent b(*store, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  ASSERT_TRUE(adjusting.WaitForNotificationWithTimeout(absl::Seconds(30)));
  ASSERT_TRUE(store->DeleteMission(kMission).ok());
  EXPECT_EQ(b.Send(b.EmptyBatch()).code(), absl::StatusCode::kAborted);
  EXPECT_TRUE(store->ListMissions({})->items.empty());
}

// A journal that calls back while a mission is being deleted.
class WatchedJournal : public InMemoryJournal {
 public:
  absl::Status DeleteMission(absl::string_view) override {
    while_deleting();
    return absl::OkStatus();
  }
  std::function<void()> while_deleting;
};

TEST_F(ThreadedStoreTest, NothingIsWrittenToAMissionThatIsBeingDeleted) {
  auto journal = std::make_unique<WatchedJournal>();
  WatchedJournal& watched = *journal;
  MapStore store(Options(), TheWorld().vocabulary, std::move(journal), &worker_);
  TestAgent a(store, kMission, "a", map_a_);
  TestAgent b(store, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  ASSERT_TRUE(store.WaitUntilFusionIdle(kMission, absl::Seconds(30)).ok());
  OverlapFilter filter;
  filter.accepted = true;
  const auto accepted = store.ListOverlaps(kMission, filter, {})->items;
  ASSERT_FALSE(accepted.empty());
  const uint64_t written = watched.records();
  int called = 0;
  watched.while_deleting = [&] {
    ++called;
    EXPECT_TRUE(absl::IsNotFound(store.RederiveGlobalLayer(kMission)));
    EXPECT_TRUE(absl::IsNotFound(store.RetractOverlap(kMission, accepted[0].id, false).status()));
  };
  ASSERT_TRUE(store.DeleteMission(kMission).ok());
  EXPECT_EQ(called, 1);
  EXPECT_EQ(watched.records(), written);
}

}  // namespace
}  // namespace corbslam::map_store
