#include "services/programs/robot/frame_rate_limit.h"

#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

constexpr int64_t kMillisecond = 1'000'000;

int CountTaken(FrameRateLimit& limit, int frames, int64_t interval_ns, int64_t first_ns = 0) {
  int taken = 0;
  for (int i = 0; i < frames; ++i) taken += limit.Takes(first_ns + i * interval_ns) ? 1 : 0;
  return taken;
}

TEST(FrameRateLimitTest, TakesAllWithoutALimitAndWhatComesSlowlyEnough) {
  FrameRateLimit limit;
  EXPECT_EQ(CountTaken(limit, 100, 50 * kMillisecond), 100);
  limit.Set(20);
  EXPECT_EQ(CountTaken(limit, 100, 50 * kMillisecond, 1'000'000 * kMillisecond), 100);
  EXPECT_EQ(limit.left_out(), 0u);
}

TEST(FrameRateLimitTest, KeepsTheRateOnAverage) {
  FrameRateLimit limit;
  limit.Set(10);
  EXPECT_EQ(CountTaken(limit, 200, 50 * kMillisecond), 100);
  EXPECT_EQ(limit.left_out(), 100u);
  // 30 frames a second are no multiple of 20.
  FrameRateLimit other;
  other.Set(20);
  EXPECT_NEAR(CountTaken(other, 300, 33'333'333), 200, 2);
}

TEST(FrameRateLimitTest, ADriveWhoseTimesGoBackBeginsAtOnce) {
  FrameRateLimit limit;
  limit.Set(1);
  EXPECT_TRUE(limit.Takes(1'000'000 * kMillisecond));
  EXPECT_FALSE(limit.Takes(1'000'100 * kMillisecond));
  EXPECT_TRUE(limit.Takes(0));
  EXPECT_FALSE(limit.Takes(100 * kMillisecond));
}

TEST(FrameRateLimitTest, AChangeHoldsFromTheNextFrameOn) {
  FrameRateLimit limit;
  limit.Set(1);
  EXPECT_TRUE(limit.Takes(0));
  EXPECT_FALSE(limit.Takes(50 * kMillisecond));
  limit.Set(0);
  EXPECT_TRUE(limit.Takes(100 * kMillisecond));
}

}  // namespace
}  // namespace corbslam::services
