#include "slam/sensor/thread_pair.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <atomic>
#include <thread>
#include <vector>

#include "absl/synchronization/notification.h"

namespace corbslam {
namespace {

TEST(ThreadPairTest, RunsEachTaskOnceAndWaitsForAll) {
  for (const bool parallel : {false, true}) {
    ThreadPair threads(parallel);
    for (size_t count = 0; count < 200; ++count) {
      std::vector<int> runs(count, 0);
      threads.Run(count, [&](size_t i) { ++runs[i]; });
      EXPECT_EQ(runs, std::vector<int>(count, 1)) << parallel;
    }
  }
}

TEST(ThreadPairTest, BothThreadsWorkAtTheSameTime) {
  ThreadPair threads(true);
  absl::Notification of_task[2];
  // Each task waits for the other: one thread alone would wait for ever.
  threads.Run(2, [&](size_t i) {
    of_task[i].Notify();
    of_task[1 - i].WaitForNotification();
  });
}

TEST(ThreadPairTest, ALongTaskDoesNotHoldUpTheOthers) {
  ThreadPair threads(true);
  std::atomic<int> others = 0;
  threads.Run(10, [&](size_t i) {
    if (i > 0) {
      ++others;
      return;
    }
    while (others < 9) std::this_thread::yield();
  });
  EXPECT_EQ(others, 9);
}

TEST(ThreadPairTest, TheOtherThreadKeepsOffTheCallersProcessor) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "there is one processor";
  ThreadPair threads(true);
  const std::thread::id caller = std::this_thread::get_id();
  while (true) {
    const int here = sched_getcpu();
    cpu_set_t of_other;
    CPU_ZERO(&of_other);
    absl::Notification of_task[2];
    threads.Run(2, [&](size_t i) {
      if (std::this_thread::get_id() != caller) sched_getaffinity(0, sizeof(of_other), &of_other);
      of_task[i].Notify();
      of_task[1 - i].WaitForNotification();
    });
    if (sched_getcpu() != here) continue;  // The caller was moved, perhaps before it ran them.
    EXPECT_FALSE(CPU_ISSET(here, &of_other));
    EXPECT_GT(CPU_COUNT(&of_other), 0);
    return;
  }
}

TEST(ThreadPairTest, WithoutAThreadTheCallerDoesAllInOrder) {
  ThreadPair threads(false);
  std::vector<size_t> order;
  threads.Run(3, [&](size_t i) { order.push_back(i); });
  EXPECT_EQ(order, (std::vector<size_t>{0, 1, 2}));
}

}  // namespace
}  // namespace corbslam
