#include "map_store/mission/memory_returner.h"

#include <gtest/gtest.h>

#include <atomic>

#include "absl/time/clock.h"

namespace corbslam::map_store {
namespace {

TEST(MemoryReturnerTest, GivesBackOnceForAllThatWasFreedTogether) {
  std::atomic<int> given_back = 0;
  MemoryReturner returner([&given_back] { ++given_back; });
  returner.Start();
  for (int i = 0; i < 20; ++i) returner.Wake();
  const absl::Time deadline = absl::Now() + absl::Seconds(60);
  while (given_back == 0 && absl::Now() < deadline) absl::SleepFor(absl::Milliseconds(20));
  EXPECT_GE(given_back, 1);
  EXPECT_LE(given_back, 2) << "one, and another one if a wake came in its pause";
  returner.Stop();
  const int before = given_back;
  returner.Wake();
  EXPECT_EQ(given_back, before);
}

TEST(MemoryReturnerTest, NeedNotBeStarted) {
  MemoryReturner returner([] { FAIL() << "nobody asked"; });
  returner.Wake();
}

}  // namespace
}  // namespace corbslam::map_store
