#include "client_agent/upload/outbox.h"

#include "gtest/gtest.h"

namespace corbslam::client_agent {
namespace {

MapUpdateBatch BatchOf(uint64_t local_map) {
  MapUpdateBatch batch;
  batch.local_map = {local_map};
  batch.lost_frames_ns = {1, 2, 3};
  return batch;
}

TEST(OutboxTest, NumbersCountPerLocalMap) {
  Outbox outbox(1 << 20);
  outbox.Push(BatchOf(7));
  outbox.Push(BatchOf(8));
  outbox.Push(BatchOf(7));
  std::vector<uint64_t> numbers;
  while (const auto batch = outbox.NextUnsent()) {
    numbers.push_back(batch->number);
    outbox.MarkSent();
  }
  EXPECT_EQ(numbers, (std::vector<uint64_t>{1, 1, 2}));
  EXPECT_EQ(outbox.local_maps(), (std::vector<LocalMapId>{{7}, {8}}));
}

TEST(OutboxTest, KeepsWhatIsNotAcknowledgedAndSendsItAgain) {
  Outbox outbox(1 << 20);
  for (int i = 0; i < 3; ++i) outbox.Push(BatchOf(7));
  outbox.MarkSent();
  outbox.MarkSent();
  outbox.Acknowledge({{7}, 1});
  EXPECT_EQ(outbox.size(), 2U);
  EXPECT_EQ(outbox.NextUnsent()->number, 3U);
  EXPECT_TRUE(outbox.Resume({}).empty());
  EXPECT_EQ(outbox.NextUnsent()->number, 2U);
}

TEST(OutboxTest, WhatTheStoreHasWithoutHavingBeenSentItIsAnothers) {
  Outbox outbox(1 << 20);
  ASSERT_TRUE(outbox.Begin({7}));
  for (int i = 0; i < 10; ++i) outbox.Push(BatchOf(7));
  const std::vector<LostLocalMap> lost = outbox.Resume({{{{7}, 9}}});
  ASSERT_EQ(lost.size(), 1U);
  EXPECT_TRUE(absl::IsAlreadyExists(lost[0].reason)) << lost[0].reason;
}

TEST(OutboxTest, AcknowledgementOfAnotherLocalMapDropsNothing) {
  Outbox outbox(1 << 20);
  outbox.Push(BatchOf(7));
  outbox.Acknowledge({{8}, 5});
  EXPECT_EQ(outbox.size(), 1U);
}

TEST(OutboxTest, NumbersGoOnAfterTheBoxWasEmpty) {
  Outbox outbox(1 << 20);
  outbox.Push(BatchOf(7));
  outbox.Acknowledge({{7}, 1});
  EXPECT_TRUE(outbox.IsEmpty());
  EXPECT_EQ(outbox.bytes(), 0U);
  outbox.Push(BatchOf(7));
  EXPECT_EQ(outbox.NextUnsent()->number, 2U);
}

TEST(OutboxTest, IsBoundedInBytes) {
  Outbox outbox(200);
  int pushed = 0;
  for (; outbox.HasRoom() && pushed < 100; ++pushed) outbox.Push(BatchOf(7));
  EXPECT_LT(pushed, 5);
  outbox.Acknowledge({{7}, 100});
  EXPECT_TRUE(outbox.HasRoom());
}

}  // namespace
}  // namespace corbslam::client_agent
