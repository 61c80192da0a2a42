#include "client_agent/mapping/mapping_queue.h"

#include <gtest/gtest.h>

#include <thread>

#include "absl/time/clock.h"

namespace corbslam {
namespace {

NewKeyframe Numbered(uint32_t index) {
  NewKeyframe keyframe;
  keyframe.reference = {LocalMapId{1}, index};
  return keyframe;
}

TEST(MappingQueueTest, KeepsTheOrderOfKeyframesAndTakesJobsFirst) {
  MappingQueue queue(3);
  EXPECT_TRUE(queue.PushKeyframe(Numbered(0)));
  EXPECT_TRUE(queue.PushKeyframe(Numbered(1)));
  queue.PostJob([](GuardedMap&) {});
  EXPECT_TRUE(std::holds_alternative<MappingJob>(*queue.TryPop()));
  EXPECT_EQ(std::get<NewKeyframe>(*queue.TryPop()).reference.index, 0u);
  EXPECT_EQ(std::get<NewKeyframe>(*queue.TryPop()).reference.index, 1u);
  EXPECT_FALSE(queue.TryPop().has_value());
}

TEST(MappingQueueTest, RefusesKeyframesBeyondItsBound) {
  MappingQueue queue(2);
  EXPECT_TRUE(queue.PushKeyframe(Numbered(0)));
  EXPECT_TRUE(queue.PushKeyframe(Numbered(1)));
  EXPECT_FALSE(queue.HasRoom());
  EXPECT_FALSE(queue.PushKeyframe(Numbered(2)));
  EXPECT_EQ(queue.keyframes(), 2u);
}

TEST(MappingQueueTest, IsBusyUntilTheItemIsDone) {
  MappingQueue queue;
  EXPECT_TRUE(queue.IsIdle());
  queue.PushKeyframe(Numbered(0));
  queue.TryPop();
  EXPECT_FALSE(queue.IsIdle());
  EXPECT_FALSE(queue.WaitUntilIdle(absl::Now() + absl::Milliseconds(5)));
  queue.Done();
  EXPECT_TRUE(queue.WaitUntilIdle(absl::Now() + absl::Milliseconds(5)));
}

TEST(MappingQueueTest, AKeyframeIsNotTakenOutOfTurnWhileAJobWaits) {
  MappingQueue queue;
  queue.PushKeyframe(Numbered(0));
  queue.PostJob([](GuardedMap&) {});
  EXPECT_FALSE(queue.TryPopKeyframe().has_value());
  queue.TryPop();
  EXPECT_TRUE(queue.TryPopKeyframe().has_value());
}

TEST(MappingQueueTest, StopWakesTheConsumerAndRefusesMore) {
  MappingQueue queue;
  std::thread consumer([&queue] { EXPECT_FALSE(queue.WaitForItem()); });
  queue.Stop();
  consumer.join();
  EXPECT_FALSE(queue.PushKeyframe(Numbered(0)));
  queue.PostJob([](GuardedMap&) {});
  EXPECT_FALSE(queue.TryPop().has_value());
}

}  // namespace
}  // namespace corbslam
