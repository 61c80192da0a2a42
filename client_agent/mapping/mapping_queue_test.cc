#include "client_agent/mapping/mapping_queue.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "absl/time/clock.h"

namespace corbslam::client_agent {
namespace {

NewKeyframe Numbered(uint32_t index) {
  NewKeyframe keyframe;
  keyframe.reference = {LocalMapId{1}, index};
  return keyframe;
}

TEST(MappingQueueTest, KeepsTheOrderOfKeyframesAndThatOfJobs) {
  MappingQueue queue(3);
  EXPECT_TRUE(queue.PushKeyframe(Numbered(0)));
  EXPECT_TRUE(queue.PushKeyframe(Numbered(1)));
  std::vector<int> done;
  queue.PostJob([&done](GuardedMap&) { done.push_back(0); });
  queue.PostJob([&done](GuardedMap&) { done.push_back(1); });
  EXPECT_EQ(queue.TryPopKeyframe()->reference.index, 0u);
  EXPECT_EQ(queue.TryPopKeyframe()->reference.index, 1u);
  EXPECT_FALSE(queue.TryPopKeyframe().has_value());
  GuardedMap map(LocalMapId{1});
  while (const auto job = queue.TryPopJob()) (*job)(map);
  EXPECT_EQ(done, (std::vector<int>{0, 1}));
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
  queue.TryPopKeyframe();
  EXPECT_FALSE(queue.IsIdle());
  EXPECT_FALSE(queue.WaitUntilIdle(absl::Now() + absl::Milliseconds(5)));
  queue.Done();
  EXPECT_TRUE(queue.WaitUntilIdle(absl::Now() + absl::Milliseconds(5)));
}

TEST(MappingQueueTest, TheConsumerIsNotSentToSleepBeforeItIsDone) {
  MappingQueue queue;
  queue.PushKeyframe(Numbered(0));
  EXPECT_TRUE(queue.TryPopKeyframe().has_value());
  EXPECT_TRUE(queue.WaitForWork());
}

TEST(MappingQueueTest, StopWakesTheConsumerAndRefusesMore) {
  MappingQueue queue;
  std::thread consumer([&queue] { EXPECT_FALSE(queue.WaitForWork()); });
  queue.Stop();
  consumer.join();
  EXPECT_FALSE(queue.PushKeyframe(Numbered(0)));
  queue.PostJob([](GuardedMap&) {});
  EXPECT_FALSE(queue.TryPopJob().has_value());
}

}  // namespace
}  // namespace corbslam::client_agent
