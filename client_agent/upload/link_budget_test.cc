#include "client_agent/upload/link_budget.h"

#include "client_agent/link/testing/test_payload.h"
#include "gtest/gtest.h"

namespace corbslam::client_agent {
namespace {

constexpr absl::Time kStart = absl::UnixEpoch();

MapUpdateBatch BatchOfKeyframes(uint32_t count) {
  MapUpdateBatch batch;
  for (uint32_t i = 0; i < count; ++i) {
    batch.full_keyframes.push_back({testing::MakeTestPayload({LocalMapId{1}, i}, 1000), {}, {}});
  }
  return batch;
}

TEST(LinkBudgetTest, WithoutABoundNothingIsHeldBack) {
  LinkBudget budget(0);
  EXPECT_FALSE(budget.is_bounded());
  budget.NoteTransport(1 << 30, 1 << 30, kStart);
  EXPECT_TRUE(budget.MaySend(kStart));
  EXPECT_TRUE(budget.MayTake(kStart));
  BatchAllowance allowance = budget.Allow(8, kStart);
  EXPECT_EQ(allowance.max_keyframes(), 8u);
  for (int i = 0; i < 1000; ++i) allowance.SpendKeyframe(1 << 20);
  EXPECT_FALSE(allowance.is_spent());
}

TEST(LinkBudgetTest, CountsWhatTheTransportHasTaken) {
  LinkBudget budget(1000);
  budget.NoteTransport(900, 2100, kStart);
  EXPECT_FALSE(budget.MaySend(kStart + absl::Seconds(1.9)));
  EXPECT_TRUE(budget.MaySend(kStart + absl::Seconds(2.1)));
  // What was written meanwhile is counted already.
  budget.NoteTransport(3000, 0, kStart + absl::Seconds(2.1));
  EXPECT_TRUE(budget.MaySend(kStart + absl::Seconds(2.1)));
}

TEST(LinkBudgetTest, WhatABrokenSessionDidNotSendIsNotCounted) {
  LinkBudget budget(1000);
  budget.NoteTransport(100, 50000, kStart);
  EXPECT_FALSE(budget.MaySend(kStart + absl::Seconds(10)));
  budget.NoteTransport(100, 0, kStart + absl::Seconds(10));
  EXPECT_TRUE(budget.MaySend(kStart + absl::Seconds(10)));
}

TEST(LinkBudgetTest, ALinkThatIsSlowerThanItsBudgetIsNotGivenMore) {
  LinkBudget budget(1000000);
  budget.NoteTransport(100, 10, kStart);
  EXPECT_TRUE(budget.MaySend(kStart));
  EXPECT_FALSE(budget.MayTake(kStart));
  budget.NoteTransport(110, 0, kStart);
  EXPECT_TRUE(budget.MayTake(kStart));
}

int KeyframesAllowed(LinkBudget& budget) {
  BatchAllowance allowance = budget.Allow(1000, kStart);
  int count = 0;
  for (; !allowance.is_spent(); ++count) allowance.SpendKeyframe(1000);
  return count;
}

TEST(LinkBudgetTest, EstimatesFollowWhatBatchesTake) {
  LinkBudget budget(1000000);
  const int before = KeyframesAllowed(budget);
  EXPECT_NEAR(before, 24, 1);
  const MapUpdateBatch batch = BatchOfKeyframes(2);
  // Batches take half their estimate, as they do with a codec.
  for (int i = 0; i < 40; ++i) budget.NoteSent(batch, EstimateWireBytes(batch) / 2);
  EXPECT_NEAR(KeyframesAllowed(budget), 2 * before, 2);
  // One transport doesn't say what it took, another one says nonsense.
  budget.NoteSent(batch, 0);
  EXPECT_NEAR(KeyframesAllowed(budget), 2 * before, 2);
  for (int i = 0; i < 100; ++i) budget.NoteSent(batch, uint64_t{1} << 60);
  EXPECT_GE(KeyframesAllowed(budget), before / 4);
}

TEST(LinkBudgetTest, ATinyBudgetStillAllowsABatch) {
  LinkBudget budget(1);
  EXPECT_TRUE(budget.MayTake(kStart));
  EXPECT_FALSE(budget.Allow(8, kStart).is_spent());
}

TEST(LinkBudgetTest, LiftedItIsNone) {
  LinkBudget budget(1000);
  budget.NoteTransport(1 << 30, 5, kStart);
  budget.Lift();
  EXPECT_FALSE(budget.is_bounded());
  EXPECT_TRUE(budget.MayTake(kStart));
  EXPECT_TRUE(budget.MaySend(kStart));
}

}  // namespace
}  // namespace corbslam::client_agent
