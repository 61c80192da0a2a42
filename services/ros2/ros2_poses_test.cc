#include "services/ros2/ros2_poses.h"

#include <gtest/gtest.h>

#include "slam/geometry/same_motion.h"

namespace corbslam::services {
namespace {

using client_agent::TrackingResult;
using client_agent::TrackingState;

Rigid3d Motion(double x, double y, double z, double yaw_rad) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitY())), {x, y, z}};
}

// A camera that looks ahead, 0.3 m ahead of and 0.5 m above base.
RecordedCamera Ahead() {
  RecordedCamera recorded;
  recorded.body_from_recorded = Rigid3d{Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {0.3, 0, 0.5}};
  return recorded;
}

Rigid3d LevelMap() { return {Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), Eigen::Vector3d::Zero()}; }

TrackingResult Tracked(const Rigid3d& local_from_camera, const Rigid3d& odom_from_camera) {
  TrackingResult result;
  result.timestamp_ns = 5;
  result.state = TrackingState::kTracking;
  result.camera_from_local = local_from_camera.Inverse();
  result.odom_from_camera = odom_from_camera;
  return result;
}

void ExpectNear(const Rigid3d& a, const Rigid3d& b) {
  EXPECT_LT((a.translation - b.translation).norm(), 1e-9);
  EXPECT_LT(RotationAngle(a.rotation.conjugate() * b.rotation), 1e-7);
}

TEST(Ros2PosesTest, BaseBeginsAtOdomAndDrivesAlongX) {
  const Ros2Mounting mounting = MakeMounting(Ahead(), LevelMap(), false);
  const Rigid3d start = Rigid3d::Identity();
  ExpectNear(*MakePoses(Tracked(start, start), mounting).odom_from_base, start);
  // Two metres ahead for the camera is along z.
  const Rigid3d moved = Motion(0, 0, 2, 0);
  const Ros2Poses poses = MakePoses(Tracked(moved, moved), mounting);
  ExpectNear(*poses.odom_from_base, {Eigen::Quaterniond::Identity(), {2, 0, 0}});
  // The map begins where the first camera stood.
  ExpectNear(*poses.map_from_base, {Eigen::Quaterniond::Identity(), {1.7, 0, -0.5}});
}

TEST(Ros2PosesTest, MapToOdomToBaseIsTheSharedPose) {
  const Ros2Mounting mounting = MakeMounting(Ahead(), LevelMap(), true);
  TrackingResult result = Tracked(Motion(1, 0.2, 3, 0.4), Motion(0.9, 0.1, 3.2, 0.35));
  Similarity3d global_from_local = Similarity3d::FromRigid(Motion(5, 0, -2, 1.2));
  global_from_local.scale = 1.01;
  result.global_from_local = global_from_local;
  const Ros2Poses poses = MakePoses(result, mounting);
  ExpectNear(*poses.MapFromOdom() * *poses.odom_from_base, *poses.map_from_base);
  // The camera is where the mission has it, turned into ROS's axes.
  const Rigid3d camera = *poses.map_from_base * mounting.camera_from_base.Inverse();
  EXPECT_LT((camera.translation -
             LevelMap() * (global_from_local * result.camera_from_local.Inverse().translation))
                .norm(),
            1e-9);
}

TEST(Ros2PosesTest, NothingIsToldThatNobodyKnows) {
  const Ros2Mounting mounting = MakeMounting(Ahead(), LevelMap(), true);
  TrackingResult result = Tracked(Motion(0, 0, 1, 0), Motion(0, 0, 1, 0));
  // With a store, and not connected: no map.
  Ros2Poses poses = MakePoses(result, mounting);
  EXPECT_TRUE(poses.odom_from_base.has_value());
  EXPECT_FALSE(poses.map_from_base.has_value());
  EXPECT_FALSE(poses.MapFromOdom().has_value());
  // Lost: odom stays as it was, and nobody knows that it did.
  result.state = TrackingState::kLost;
  result.global_from_local = Similarity3d::Identity();
  poses = MakePoses(result, mounting);
  EXPECT_FALSE(poses.odom_from_base.has_value());
  EXPECT_FALSE(poses.map_from_base.has_value());
  // By an IMU.
  result.reckoned.emplace();
  poses = MakePoses(result, mounting);
  EXPECT_TRUE(poses.odom_from_base.has_value());
  EXPECT_TRUE(poses.is_reckoned);
  EXPECT_FALSE(poses.map_from_base.has_value());
}

TEST(Ros2PosesTest, ABaseThatIsTheCameraIsTurnedLevel) {
  RecordedCamera recorded;
  recorded.body_from_recorded = Rigid3d::Identity();
  const Ros2Mounting mounting = MakeMounting(recorded, LevelMap(), false);
  const Rigid3d moved = Motion(0, 0, 2, 0);
  const Ros2Poses poses = MakePoses(Tracked(moved, moved), mounting);
  EXPECT_LT((poses.odom_from_base->translation - Eigen::Vector3d(2, 0, 0)).norm(), 1e-9);
}

TEST(Ros2PosesTest, CovarianceIsTurnedIntoTheMapsAxes) {
  RecordedCamera recorded;
  recorded.body_from_recorded = Rigid3d::Identity();
  const Ros2Mounting mounting = MakeMounting(recorded, LevelMap(), false);
  TrackingResult result = Tracked(Rigid3d::Identity(), Rigid3d::Identity());
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal() << 1, 2, 3, 4, 5, 6;
  result.covariance = covariance;
  const Ros2Poses poses = MakePoses(result, mounting);
  // The camera's z is the map's x, its x the map's -y, its y the map's -z.
  Vector6d expected;
  expected << 3, 1, 2, 6, 4, 5;
  EXPECT_TRUE(poses.map_covariance->diagonal().isApprox(expected));
  EXPECT_FALSE(poses.odom_covariance.has_value());
  result.drift = covariance;
  EXPECT_TRUE(MakePoses(result, mounting).odom_covariance->diagonal().isApprox(2 * expected));
}

TEST(Ros2PosesTest, VelocityIsBases) {
  const Ros2Mounting mounting = MakeMounting(Ahead(), LevelMap(), false);
  TrackingResult result = Tracked(Motion(0, 0, 1, 0), Motion(0, 0, 1, 0));
  result.motion.emplace();
  result.motion->camera_from_previous = Motion(0, 0, -0.1, 0);  // It was 0.1 m behind.
  result.motion->since_ns = 100'000'000;
  const Ros2Poses poses = MakePoses(result, mounting);
  Vector6d expected;
  expected << 1, 0, 0, 0, 0, 0;
  EXPECT_LT((*poses.velocity - expected).norm(), 1e-9);
}

}  // namespace
}  // namespace corbslam::services
