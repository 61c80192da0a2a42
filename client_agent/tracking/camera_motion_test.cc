#include "client_agent/tracking/camera_motion.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <initializer_list>

#include "slam/geometry/lie.h"

namespace corbslam::client_agent {
namespace {

constexpr int64_t kInterval = 100'000'000;

FrameRhythm TenASecond(std::initializer_list<int64_t> jitter_ms) {
  FrameRhythm rhythm;
  for (const int64_t ms : jitter_ms) rhythm.Add(kInterval + ms * 1'000'000);
  return rhythm;
}

TEST(FrameRhythmTest, CountsTheFramesOfAGap) {
  const FrameRhythm rhythm = TenASecond({0, 100, 0, 0, 200, 0, 0});
  EXPECT_EQ(rhythm.FramesIn(kInterval), 1);
  EXPECT_EQ(rhythm.FramesIn(2 * kInterval), 2);
  EXPECT_EQ(rhythm.FramesIn(4 * kInterval), 4);
  EXPECT_EQ(rhythm.FramesIn(-3 * kInterval), 3) << "a recording that is played backwards";
  const FrameRhythm at_first = TenASecond({0, 300});
  EXPECT_EQ(at_first.FramesIn(4 * kInterval), 4);
  EXPECT_EQ(TenASecond({300, 100, 0, 100, 300, 0}).FramesIn(4 * kInterval), 4) << "mostly gaps";
}

TEST(FrameRhythmTest, JitterOfTheStampsIsNoGap) {
  const FrameRhythm rhythm = TenASecond({-20, 15, -10, 0, 20, -15, 10});
  for (const int64_t ms : {1, 80, 100, 120}) EXPECT_EQ(rhythm.FramesIn(ms * 1'000'000), 1) << ms;
}

TEST(FrameRhythmTest, WithoutTimesEachFrameFollowsTheOneBefore) {
  EXPECT_EQ(FrameRhythm().FramesIn(7 * kInterval), 1);
  FrameRhythm stands_still;
  stands_still.Add(0);
  EXPECT_EQ(stands_still.FramesIn(kInterval), 1);
  EXPECT_GE(TenASecond({0}).FramesIn(INT64_MAX), 1) << "a clock that was set";
}

TEST(FrameRhythmTest, FollowsACameraThatBecomesSlower) {
  FrameRhythm rhythm = TenASecond({0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(rhythm.FramesIn(2 * kInterval), 2);
  for (int i = 0; i < 12; ++i) rhythm.Add(2 * kInterval);
  EXPECT_EQ(rhythm.FramesIn(2 * kInterval), 1);
}

TEST(GoOnForTest, IsTheMotionSoManyTimes) {
  // A car in a bend: a metre ahead and four degrees to the side.
  const Rigid3d once = ExpSE3((Vector6d() << 0, 0, -1, 0, 0.07, 0).finished());
  const auto differ = [](const Rigid3d& a, const Rigid3d& b) {
    return LogSE3(a * b.Inverse()).norm();
  };
  EXPECT_LT(differ(GoOnFor(3, once), once * once * once), 1e-12);
  EXPECT_LT(differ(GoOnFor(0.5, once) * GoOnFor(0.5, once), once), 1e-12);
}

}  // namespace
}  // namespace corbslam::client_agent
