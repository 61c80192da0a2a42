#include "client_agent/agent/pose_drift.h"

#include <gtest/gtest.h>

namespace corbslam::client_agent {
namespace {

constexpr double kVariance = 1e-4;

// A camera at x, one metre on from the frame before, with a covariance of its own.
TrackingResult At(double x) {
  TrackingResult result;
  result.state = TrackingState::kTracking;
  result.camera_from_local.translation = {-x, 0, 0};
  result.motion = CameraMotion{{Eigen::Quaterniond::Identity(), {-1, 0, 0}}, 1};
  result.covariance = Matrix6d(kVariance * Matrix6d::Identity());
  return result;
}

TEST(PoseDriftTest, NothingHasDriftedAtTheBeginning) {
  PoseDrift drift;
  EXPECT_FALSE(drift.drift().has_value());
  drift.Begin(At(0));
  ASSERT_TRUE(drift.drift().has_value());
  EXPECT_TRUE(drift.drift()->isZero());
}

TEST(PoseDriftTest, GrowsFrameByFrameAndWithTheWay) {
  PoseDrift drift;
  drift.Begin(At(0));
  for (int x = 1; x <= 2; ++x) drift.GoOn(At(x));
  ASSERT_TRUE(drift.drift().has_value());
  EXPECT_NEAR((*drift.drift())(0, 0), 2 * kVariance, 1e-12);
  // What it turned by a metre and by two metres ago moves it sideways.
  EXPECT_NEAR((*drift.drift())(1, 1), (2 + 1 + 4) * kVariance, 1e-12);
  EXPECT_NEAR((*drift.drift())(5, 5), 2 * kVariance, 1e-12);
}

TEST(PoseDriftTest, HasInWhatTheMapWasMovedBy) {
  PoseDrift drift;
  drift.Begin(At(0));
  drift.GoOn(At(1.5));
  ASSERT_TRUE(drift.drift().has_value());
  // The camera went on by one metre and stands one and a half from where it said it stood.
  EXPECT_NEAR((*drift.drift())(0, 0), kVariance + 0.25, 1e-12);
}

TEST(PoseDriftTest, TheRateIsWhatAdjustmentShows) {
  PoseDrift drift;
  EXPECT_EQ(drift.rate(), 1);
  double x = 0;
  drift.Begin(At(x));
  for (int i = 0; i < 80; ++i) {
    // Each frame is a keyframe, and the map is moved by two standard deviations under each.
    x += 1.02;
    TrackingResult result = At(x);
    result.made_keyframe = true;
    drift.GoOn(result);
  }
  // Rotations about the camera do nothing along the way.
  EXPECT_NEAR(drift.rate(), 4 / 5.348, 1e-3);
}

TEST(PoseDriftTest, WhereNothingIsAdjustedTheRateStays) {
  PoseDrift drift;
  drift.Begin(At(0));
  for (int x = 1; x < 40; ++x) {
    TrackingResult result = At(x);
    result.made_keyframe = true;
    drift.GoOn(result);
  }
  EXPECT_EQ(drift.rate(), 1);
}

TEST(PoseDriftTest, ClaimsNothingAfterAFrameThatSaysNothing) {
  PoseDrift drift;
  drift.Begin(At(0));
  TrackingResult unknown = At(1);
  unknown.motion.reset();
  drift.GoOn(unknown);
  drift.GoOn(At(2));
  EXPECT_FALSE(drift.drift().has_value());
  drift.Begin(At(3));
  EXPECT_TRUE(drift.drift().has_value());
}

TEST(PoseDriftTest, BetweenTwoFramesOnlyWhatCameBetween) {
  PoseDrift drift;
  drift.Begin(At(0));
  TrackingResult from;
  for (int x = 1; x <= 5; ++x) {
    TrackingResult result = At(x);
    drift.GoOn(result);
    result.drift = drift.drift();
    if (x == 4) from = result;
    if (x == 5) {
      const Matrix6d between = DriftBetween(from, result);
      EXPECT_NEAR(between(0, 0), kVariance, 1e-12);
      EXPECT_NEAR(between(1, 1), 2 * kVariance, 1e-12);
      EXPECT_NEAR(between(3, 3), kVariance, 1e-12);
    }
  }
}

}  // namespace
}  // namespace corbslam::client_agent
