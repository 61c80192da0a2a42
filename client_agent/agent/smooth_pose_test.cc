#include "client_agent/agent/smooth_pose.h"

#include <gtest/gtest.h>

#include "slam/geometry/lie.h"

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kFirst{1};
constexpr LocalMapId kSecond{2};

Rigid3d At(double x) { return {Eigen::Quaterniond::Identity(), {x, 0, 0}}; }

// A camera that stands at `x` in its local map, `moved` on from where it was before.
TrackingResult Tracked(double x, double moved, LocalMapId map = kFirst, uint64_t corrections = 0) {
  TrackingResult result;
  result.state = TrackingState::kTracking;
  result.local_map = map;
  result.corrections = corrections;
  result.camera_from_local = At(x).Inverse();
  result.motion = CameraMotion{At(moved).Inverse(), 100'000'000};
  return result;
}

TrackingResult Lost() {
  TrackingResult result;
  result.state = TrackingState::kLost;
  return result;
}

class SmoothPoseTest : public ::testing::Test {
 protected:
  // Returns where the frame is in odom.
  double Add(TrackingResult result) {
    smooth_.Add(result);
    epoch_ = result.epoch;
    EXPECT_TRUE(result.odom_from_camera.has_value());
    return result.odom_from_camera.has_value() ? result.odom_from_camera->translation.x() : -1;
  }

  SmoothPose smooth_;
  uint64_t epoch_ = 0;
};

TEST_F(SmoothPoseTest, ThereIsNoneBeforeTheFirstPose) {
  TrackingResult nothing;
  smooth_.Add(nothing);
  EXPECT_FALSE(nothing.odom_from_camera.has_value());
  EXPECT_EQ(nothing.epoch, 0u);
}

// What an IMU says `moved` since the last frame that had a pose.
TrackingResult Reckoned(double moved) {
  TrackingResult result = Lost();
  result.reckoned.emplace();
  result.reckoned->motion = {At(moved).Inverse(), 100'000'000};
  return result;
}

TEST_F(SmoothPoseTest, GoesOnByWhatAnImuSaysUntilTheCameraIsFound) {
  Add(Tracked(3, 0));
  EXPECT_DOUBLE_EQ(Add(Reckoned(1)), 4);
  EXPECT_DOUBLE_EQ(Add(Reckoned(2)), 5);
  // Nobody knows more: it stays.
  EXPECT_DOUBLE_EQ(Add(Lost()), 5);
  EXPECT_DOUBLE_EQ(Add(Reckoned(3)), 6);
  // The IMU was wrong by half a metre.
  EXPECT_DOUBLE_EQ(Add(Tracked(6.5, 3.5)), 6.5);
}

TEST_F(SmoothPoseTest, FollowsMotionsInOneEpoch) {
  EXPECT_DOUBLE_EQ(Add(Tracked(3, 0)), 3);
  EXPECT_EQ(epoch_, 1u);
  EXPECT_DOUBLE_EQ(Add(Tracked(4, 1)), 4);
  EXPECT_DOUBLE_EQ(Add(Tracked(6, 2)), 6);
  EXPECT_EQ(epoch_, 1u);
}

TEST_F(SmoothPoseTest, ACorrectionMovesTheMapOnly) {
  Add(Tracked(0, 0));
  // The map was moved by 10 while the camera went on by 1.
  EXPECT_DOUBLE_EQ(Add(Tracked(11, 1, kFirst, 1)), 1);
  EXPECT_EQ(epoch_, 2u);
  EXPECT_DOUBLE_EQ(Add(Tracked(12, 1, kFirst, 1)), 2);
  EXPECT_EQ(epoch_, 2u);
}

TEST_F(SmoothPoseTest, FoundAgainInTheSameMapItHasMovedWhileLost) {
  Add(Tracked(0, 0));
  EXPECT_DOUBLE_EQ(Add(Lost()), 0) << "the last smooth pose stays";
  EXPECT_EQ(epoch_, 1u);
  EXPECT_DOUBLE_EQ(Add(Tracked(5, 5)), 5);
  EXPECT_EQ(epoch_, 2u);
}

TEST_F(SmoothPoseTest, InAnotherMapItGoesOnFromWhereItWas) {
  Add(Tracked(7, 0));
  TrackingResult other = Tracked(0, 0, kSecond);
  other.motion = std::nullopt;
  EXPECT_DOUBLE_EQ(Add(other), 7);
  EXPECT_EQ(epoch_, 2u);
  EXPECT_DOUBLE_EQ(Add(Tracked(1, 1, kSecond)), 8);
  EXPECT_EQ(epoch_, 2u);
}

TEST_F(SmoothPoseTest, AHandOverIsNoJump) {
  Add(Tracked(0, 0));
  Add(Tracked(11, 1, kFirst, 1));
  smooth_.GoOnIn(kSecond);
  EXPECT_DOUBLE_EQ(Add(Tracked(12, 1, kSecond)), 2);
  EXPECT_EQ(epoch_, 2u) << "the correction's";
  EXPECT_DOUBLE_EQ(Add(Tracked(20, 1, kSecond, 1)), 3);
  EXPECT_EQ(epoch_, 3u) << "a correction of the new local map";
}

TEST_F(SmoothPoseTest, AJumpBeginsTheDriftAnew) {
  const auto drift_at = [&](TrackingResult result) {
    result.covariance = Matrix6d::Identity();
    smooth_.Add(result);
    return result.drift.value_or(-Matrix6d::Identity())(0, 0);
  };
  EXPECT_EQ(drift_at(Tracked(0, 0)), 0);
  EXPECT_NEAR(drift_at(Tracked(1, 1)), 1, 1e-9);
  EXPECT_NEAR(drift_at(Tracked(2, 1)), 2, 1e-9);
  EXPECT_EQ(drift_at(Tracked(11, 1, kFirst, 1)), 0);
  smooth_.GoOnIn(kSecond);
  EXPECT_NEAR(drift_at(Tracked(12, 1, kSecond)), 1, 1e-9) << "a hand-over is no jump";
}

TEST(PoseQualityTest, GrowsWithPointsAndTheirShare) {
  TrackingResult result = Tracked(0, 0);
  EXPECT_EQ(PoseQuality(result), 0);
  result.points_matched = 100;
  result.points_in_view = 200;
  EXPECT_DOUBLE_EQ(PoseQuality(result), 0.5);
  result.points_in_view = 1000;
  EXPECT_NEAR(PoseQuality(result), 1.0 / 3, 1e-9);
  result.points_matched = 900;
  EXPECT_DOUBLE_EQ(PoseQuality(result), 0.9);
  result.state = TrackingState::kLost;
  EXPECT_EQ(PoseQuality(result), 0);
}

}  // namespace
}  // namespace corbslam::client_agent
