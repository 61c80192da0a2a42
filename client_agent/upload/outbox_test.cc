#include "client_agent/upload/outbox.h"

#include <random>

#include "absl/time/clock.h"
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

// After a long outage so many wait, and each is acknowledged under the link's lock.
TEST(OutboxTest, AnAcknowledgementTakesAsLongHoweverManyBatchesWait) {
  constexpr uint64_t kWaiting = 100'000;
  Outbox outbox(0);
  for (uint64_t i = 0; i < kWaiting; ++i) {
    for (const uint64_t local_map : {7, 8}) outbox.Push(BatchOf(local_map));
  }
  const absl::Time start = absl::Now();
  for (uint64_t number = 1; number <= kWaiting; ++number) {
    for (int i = 0; i < 2; ++i) outbox.MarkSent();
    // The second local map's come first, and the first one's of before behind them.
    outbox.Acknowledge({{8}, number});
    if (number > 1) outbox.Acknowledge({{7}, number - 1});
  }
  EXPECT_LT(absl::Now() - start, absl::Seconds(3)) << "moving all that wait takes minutes";
  EXPECT_EQ(outbox.size(), 1u);
}

TEST(OutboxTest, WhatIsAcknowledgedInAnyOrderGoesAndNothingElse) {
  std::mt19937 random(3);
  Outbox outbox(1 << 30);
  std::vector<std::pair<uint64_t, uint64_t>> waiting;  // Local map and number.
  std::map<uint64_t, uint64_t> last;
  size_t sent = 0;
  for (int step = 0; step < 5000; ++step) {
    const uint64_t local_map = 1 + random() % 3;
    const auto kind = random() % 3;
    if (kind == 0) {
      outbox.Push(BatchOf(local_map));
      waiting.emplace_back(local_map, ++last[local_map]);
    } else if (kind == 1 && outbox.NextUnsent() != nullptr) {
      outbox.MarkSent();
      ++sent;
    } else if (last[local_map] > 0) {
      const uint64_t number = 1 + random() % last[local_map];
      outbox.Acknowledge({{local_map}, number});
      for (size_t i = waiting.size(); i-- > 0;) {
        if (waiting[i].first != local_map || waiting[i].second > number) continue;
        waiting.erase(waiting.begin() + static_cast<ptrdiff_t>(i));
        if (i < sent) --sent;
      }
    }
    ASSERT_EQ(outbox.size(), waiting.size());
    const Outbox::Entry* next = outbox.NextUnsent();
    ASSERT_EQ(next == nullptr, sent == waiting.size());
    if (next == nullptr) continue;
    ASSERT_EQ(next->local_map.value, waiting[sent].first);
    ASSERT_EQ(next->number, waiting[sent].second);
  }
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
