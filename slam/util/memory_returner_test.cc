#include "slam/util/memory_returner.h"

#include <gtest/gtest.h>

#include <atomic>

#include "absl/time/clock.h"

namespace corbslam {
namespace {

void WaitFor(const std::atomic<int>& count, int least) {
  const absl::Time deadline = absl::Now() + absl::Seconds(60);
  while (count < least && absl::Now() < deadline) absl::SleepFor(absl::Milliseconds(5));
}

TEST(MemoryReturnerTest, GivesBackOnceForAllThatWasFreedTogether) {
  std::atomic<int> given_back = 0;
  MemoryReturner returner([&given_back] { ++given_back; });
  returner.Start();
  for (int i = 0; i < 20; ++i) returner.Wake();
  WaitFor(given_back, 1);
  EXPECT_EQ(given_back, 1);
  returner.Stop();
  returner.Wake();
  EXPECT_EQ(given_back, 1);
}

TEST(MemoryReturnerTest, WhatIsFreedAllTheTimeGoesBackNowAndThen) {
  std::atomic<int> given_back = 0;
  MemoryReturner returner([&given_back] { ++given_back; },
                          {.pause = absl::Milliseconds(10), .between = absl::Milliseconds(200)});
  returner.Start();
  const absl::Time begin = absl::Now();
  while (given_back < 4) {
    returner.Wake();
    absl::SleepFor(absl::Milliseconds(1));
    ASSERT_LT(absl::Now(), begin + absl::Seconds(60));
  }
  EXPECT_GE(absl::Now(), begin + absl::Milliseconds(600));
}

// What is freed while all else is given back is not given back with it.
TEST(MemoryReturnerTest, AWakeMeanwhileCounts) {
  std::atomic<int> given_back = 0;
  MemoryReturner* raw = nullptr;
  MemoryReturner returner(
      [&] {
        if (++given_back == 1) raw->Wake();
      },
      {.pause = absl::Milliseconds(1),
       .between = absl::Milliseconds(2),
       .later = absl::InfiniteDuration()});
  raw = &returner;
  returner.Start();
  returner.Wake();
  WaitFor(given_back, 2);
  EXPECT_EQ(given_back, 2);
}

TEST(MemoryReturnerTest, LooksOnceMoreWhenNothingComesAnyMore) {
  std::atomic<int> given_back = 0;
  MemoryReturner returner([&given_back] { ++given_back; }, {.pause = absl::Milliseconds(1),
                                                            .between = absl::Milliseconds(2),
                                                            .later = absl::Milliseconds(100)});
  returner.Start();
  const absl::Time begin = absl::Now();
  returner.Wake();
  WaitFor(given_back, 2);
  EXPECT_GE(absl::Now(), begin + absl::Milliseconds(100));
  absl::SleepFor(absl::Milliseconds(300));
  EXPECT_EQ(given_back, 2) << "nobody woke it since";
}

TEST(MemoryReturnerTest, NeedNotBeStarted) {
  MemoryReturner returner([] { FAIL() << "nobody asked"; });
  returner.Wake();
}

}  // namespace
}  // namespace corbslam
