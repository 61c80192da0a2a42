#include "client_agent/tracking/camera_motion.h"

#include <gtest/gtest.h>

#include "slam/geometry/lie.h"

namespace corbslam::client_agent {
namespace {

constexpr int64_t kInterval = 100'000'000;

// A car in a bend: a metre ahead and four degrees to the side in an interval.
CameraMotion InABend() {
  return {ExpSE3((Vector6d() << 0, 0, -1, 0, 0.07, 0).finished()), kInterval};
}

bool IsSame(const Rigid3d& a, const Rigid3d& b) { return LogSE3(a * b.Inverse()).norm() < 1e-12; }

TEST(CameraMotionTest, GoesOnForAsLongAsFramesWereDropped) {
  const Rigid3d once = InABend().camera_from_previous;
  EXPECT_TRUE(IsSame(MotionWithin(2 * kInterval, InABend()), once * once));
  EXPECT_TRUE(IsSame(MotionWithin(4 * kInterval, InABend()), once * once * once * once));
  const Rigid3d half = MotionWithin(kInterval / 2, InABend());
  EXPECT_TRUE(IsSame(half * half, once)) << "the interval before was the long one";
}

TEST(CameraMotionTest, JitterOfTheStampsIsNoMotion) {
  const CameraMotion before = InABend();
  for (const int64_t since : {kInterval, kInterval * 9 / 10, kInterval * 11 / 10}) {
    EXPECT_TRUE(MotionWithin(since, before).translation == before.camera_from_previous.translation);
  }
}

TEST(CameraMotionTest, IsAsItWasWhereTimeSaysNothing) {
  CameraMotion before = InABend();
  const Rigid3d once = before.camera_from_previous;
  EXPECT_TRUE(IsSame(MotionWithin(0, before), once));
  EXPECT_TRUE(IsSame(MotionWithin(-kInterval, before), once));
  EXPECT_TRUE(IsSame(MotionWithin(-2 * kInterval, {once, -kInterval}), once * once))
      << "a recording that is played backwards";
  before.since_ns = 0;
  EXPECT_TRUE(IsSame(MotionWithin(kInterval, before), once));
}

}  // namespace
}  // namespace corbslam::client_agent
