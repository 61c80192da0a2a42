#include "map_store/process/memory_budget.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/time/clock.h"
#include "map_store/testing/two_robots.h"
#include "slam/util/resident_memory.h"

namespace corbslam::map_store {
namespace {

using ::testing::HasSubstr;

constexpr uint64_t kMiB = 1 << 20;

TEST(MemoryBudgetTest, TakesWhatFits) {
  uint64_t resident = 60 * kMiB;
  MemoryBudget budget(
      100 * kMiB, [&] { return resident; }, &absl::Now);
  EXPECT_TRUE(budget.Check("a batch", 40 * kMiB).ok());
  EXPECT_EQ(budget.refused(), 0u);
  const absl::Status too_much = budget.Check("a batch", 40 * kMiB + 1024);
  EXPECT_EQ(too_much.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(too_much.message()),
              HasSubstr("60 MiB in memory of a budget of 100 MiB"));
  resident = 120 * kMiB;
  EXPECT_FALSE(budget.Check("a batch", 0).ok());
  EXPECT_FALSE(budget.Check("a batch", ~uint64_t{0}).ok()) << "no sum runs over";
  EXPECT_EQ(budget.refused(), 3u);
  resident = 10 * kMiB;
  EXPECT_TRUE(budget.Check("a batch", kMiB).ok()) << "room was made";
}

TEST(MemoryBudgetTest, NoLimitTakesAll) {
  MemoryBudget budget(
      0, [] { return ~uint64_t{0}; }, &absl::Now);
  EXPECT_TRUE(budget.Check("a batch", ~uint64_t{0}).ok());
}

TEST(MemoryBudgetTest, MakesRoomBeforeItRefuses) {
  uint64_t resident = 120 * kMiB;
  MemoryBudget budget(
      100 * kMiB, [&] { return resident; }, &absl::Now);
  int asleep = 0;
  budget.SetRoomMaker([&] {
    if (asleep == 3) return false;
    ++asleep;
    resident -= 10 * kMiB;
    return true;
  });
  EXPECT_TRUE(budget.IsShort());
  EXPECT_TRUE(budget.Check("a batch", 5 * kMiB).ok());
  EXPECT_EQ(asleep, 3) << "no more than it takes";
  EXPECT_TRUE(budget.IsShort()) << "less than an eighth is left";
  EXPECT_FALSE(budget.Check("a batch", 20 * kMiB).ok());
  EXPECT_EQ(budget.refused(), 1u);
  resident = 80 * kMiB;
  EXPECT_FALSE(budget.IsShort());
}

TEST(MemoryBudgetTest, WhoCanComeAgainIsRefusedAtOnceAndRoomIsMadeMeanwhile) {
  MemoryBudget budget(
      100 * kMiB, [] { return 120 * kMiB; }, &absl::Now);
  budget.SetRoomMaker([] {
    ADD_FAILURE() << "a robot's batch waits for it";
    return false;
  });
  EXPECT_FALSE(budget.TakeWanted());
  EXPECT_EQ(budget.CheckAtOnce("a batch", kMiB).code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(budget.refused(), 1u);
  EXPECT_TRUE(budget.TakeWanted());
  EXPECT_FALSE(budget.TakeWanted());
}

TEST(MemoryBudgetTest, WhatTheAllocatorKeepsDoesNotCount) {
  int measured = 0;
  uint64_t resident = 60 * kMiB;
  MemoryBudget budget(
      100 * kMiB, [&] { return resident; }, &absl::Now,
      [&] {
        ++measured;
        return 50 * kMiB;
      });
  EXPECT_TRUE(budget.Check("a batch", 30 * kMiB).ok());
  EXPECT_FALSE(budget.IsShort());
  EXPECT_EQ(measured, 0) << "while there is room, the heap is not looked at";
  resident = 130 * kMiB;
  EXPECT_TRUE(budget.Check("a batch", 30 * kMiB).ok());
  EXPECT_TRUE(budget.CheckAtOnce("a batch", 30 * kMiB).ok());
  EXPECT_FALSE(budget.IsShort());
  EXPECT_FALSE(budget.CheckAtOnce("a batch", 60 * kMiB).ok());
}

class FullStore : public ::corbslam::testing::TwoRobots {
 protected:
  static MapStoreOptions Options(uint64_t budget) {
    MapStoreOptions options = ::corbslam::testing::DeterministicOptions();
    options.memory_budget_bytes = budget;
    return options;
  }
};

TEST_F(FullStore, RefusesABatchWholeAndTheSessionGoesOn) {
  MapStore store(Options(ResidentBytes() / 2), ::corbslam::testing::TheWorld().vocabulary,
                 std::make_unique<InMemoryJournal>(), nullptr);
  ::corbslam::testing::TestAgent robot(store, kMission, "a", map_a_);
  const MapUpdateBatch batch = robot.NextBatch(1);
  for (int attempt = 0; attempt < 2; ++attempt) {
    const absl::Status refused = robot.Send(batch);
    EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted) << refused;
    EXPECT_THAT(std::string(refused.message()), HasSubstr("--memory-budget"));
  }
  EXPECT_EQ(store.memory().refused, 2u);
  EXPECT_EQ(store.GetMission(kMission)->keyframes, 0u) << "nothing of it was stored";
}

TEST_F(FullStore, RefusesWhatIsRestored) {
  ASSERT_TRUE(a_.Stream().ok());
  auto backup = store_.BackUpMission(kMission);
  ASSERT_TRUE(backup.ok());
  MapStore store(Options(ResidentBytes() / 2), ::corbslam::testing::TheWorld().vocabulary,
                 std::make_unique<InMemoryJournal>(), nullptr);
  MissionRestorer restorer = store.StartRestoring();
  EXPECT_EQ(restorer.Add(backup->Next(1 << 20)).code(), absl::StatusCode::kResourceExhausted);
}

}  // namespace
}  // namespace corbslam::map_store
