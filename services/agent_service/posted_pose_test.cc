#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "services/agent_service/pose_board.h"

namespace corbslam::services {
namespace {

using client_agent::CameraMotion;
using client_agent::TrackingResult;
using client_agent::TrackingState;
using client_agent::WhyNoPose;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// A camera 2 m along z that has moved forwards by 0.1 m in a tenth of a second.
TrackingResult Tracked() {
  TrackingResult result;
  result.timestamp_ns = 1'000'000'000;
  result.state = TrackingState::kTracking;
  result.camera_from_local.translation = {0, 0, -2};
  result.odom_from_camera = Rigid3d{Eigen::Quaterniond::Identity(), {0, 0, 1.5}};
  result.motion = CameraMotion{{Eigen::Quaterniond::Identity(), {0, 0, -0.1}}, 100'000'000};
  result.covariance = Matrix6d(1e-4 * Matrix6d::Identity());
  result.drift = Matrix6d(1e-2 * Matrix6d::Identity());
  result.points_matched = 300;
  result.points_in_view = 900;
  result.epoch = 3;
  return result;
}

TrackingResult Lost() {
  TrackingResult result;
  result.state = TrackingState::kLost;
  result.why_no_pose = WhyNoPose::kNotRecognised;
  result.odom_from_camera = Rigid3d{Eigen::Quaterniond::Identity(), {0, 0, 1.5}};
  return result;
}

TrackingResult Placed(TrackingResult result, const Similarity3d& global_from_local) {
  result.global_from_local = global_from_local;
  return result;
}

TEST(PostedPoseTest, SaysWhereLengthsAreNoMetres) {
  TrackingResult result = Tracked();
  const auto metric = ToProto({.result = result}, PosesOf::kRectifiedCamera, std::nullopt);
  EXPECT_FALSE(metric.without_metres());
  result.without_metres = true;
  result.global_without_metres = true;
  const auto alone = ToProto({.result = result}, PosesOf::kRectifiedCamera, std::nullopt);
  EXPECT_TRUE(alone.without_metres());
  EXPECT_FALSE(alone.global_without_metres()) << "there is no global frame yet";
  const auto placed = ToProto({.result = Placed(result, Similarity3d::Identity())},
                              PosesOf::kRectifiedCamera, std::nullopt);
  EXPECT_TRUE(placed.global_without_metres());
}

TEST(PostedPoseTest, SaysWhileOneCameraWaitsForParallax) {
  TrackingResult result;
  result.why_no_pose = WhyNoPose::kLittleParallax;
  const auto pose = ToProto({.result = result}, PosesOf::kRectifiedCamera, std::nullopt);
  EXPECT_EQ(pose.state(), v1::TRACKING_STATE_INITIALISING);
  EXPECT_EQ(pose.why_no_pose(), v1::WHY_NO_POSE_LITTLE_PARALLAX);
}

TEST(PostedPoseTest, SaysHowSureItIsAndHowItMoves) {
  const auto pose = ToProto({.result = Tracked(), .follows_a_pose = true},
                            PosesOf::kRectifiedCamera, std::nullopt);
  EXPECT_THAT(pose.covariance(), SizeIs(36));
  EXPECT_DOUBLE_EQ(pose.covariance(0), 1e-4);
  EXPECT_DOUBLE_EQ(pose.covariance(1), 0);
  ASSERT_THAT(pose.drift(), SizeIs(36));
  EXPECT_DOUBLE_EQ(pose.drift(0), 1e-2);
  EXPECT_DOUBLE_EQ(pose.quality(), 0.75);
  EXPECT_EQ(pose.points_matched(), 300u);
  EXPECT_EQ(pose.points_in_view(), 900u);
  EXPECT_EQ(pose.epoch(), 3u);
  ASSERT_THAT(pose.velocity(), SizeIs(6));
  EXPECT_NEAR(pose.velocity(2), 1, 1e-12) << "a metre a second forwards";
  EXPECT_NEAR(pose.velocity(0), 0, 1e-12);
  EXPECT_NEAR(pose.odom_from_camera().translation(2), 1.5, 1e-12);
  EXPECT_NEAR(pose.map_from_odom().translation(2), 0.5, 1e-12) << "what corrections did";
}

TEST(PostedPoseTest, APoseOfTheBodyHasTheBodysErrorsAndVelocity) {
  TrackingResult result = Tracked();
  // It turns about y by 0.1 rad in a tenth of a second, without moving.
  result.motion->camera_from_previous = {
      Eigen::Quaterniond(Eigen::AngleAxisd(-0.1, Eigen::Vector3d::UnitY())),
      Eigen::Vector3d::Zero()};
  // The body's origin is 2 m along z of the camera.
  const Rigid3d camera_from_body{Eigen::Quaterniond::Identity(), {0, 0, 2}};
  const auto pose =
      ToProto({.result = result, .follows_a_pose = true}, PosesOf::kBody, camera_from_body);
  EXPECT_NEAR(pose.local_from_camera().translation(2), 4, 1e-12);
  EXPECT_NEAR(pose.velocity(0), 2, 1e-9) << "it swings sideways";
  EXPECT_NEAR(pose.velocity(4), 1, 1e-9);
  EXPECT_NEAR(pose.covariance(0), 1e-4 + 4 * 1e-4, 1e-12);
  EXPECT_NEAR(pose.covariance(14), 1e-4, 1e-12);
  EXPECT_NEAR(pose.drift(0), 5e-2, 1e-12);
  EXPECT_NEAR(pose.map_from_odom().translation(2), 0.5, 1e-12) << "whatever rides on the robot";
}

TEST(PostedPoseTest, LostItClaimsNothing) {
  const auto pose = ToProto({.result = Lost()}, PosesOf::kRectifiedCamera, std::nullopt);
  EXPECT_EQ(pose.why_no_pose(), v1::WHY_NO_POSE_NOT_RECOGNISED);
  EXPECT_FALSE(pose.has_local_from_camera());
  EXPECT_FALSE(pose.has_map_from_odom());
  EXPECT_TRUE(pose.has_odom_from_camera()) << "the smooth pose stays";
  EXPECT_THAT(pose.covariance(), IsEmpty());
  EXPECT_THAT(pose.drift(), IsEmpty());
  EXPECT_THAT(pose.velocity(), IsEmpty());
  EXPECT_EQ(pose.quality(), 0);
}

TEST(PostedPoseTest, LostItSaysWhereTheImuTakesItAndThatThisIsNoPose) {
  TrackingResult result = Lost();
  result.reckoned.emplace();
  result.reckoned->camera_from_local.translation = {0, 0, -3};
  result.reckoned->covariance = Matrix6d(1e-2 * Matrix6d::Identity());
  result.reckoned->motion.since_ns = 1'500'000'000;
  const Rigid3d camera_from_body{Eigen::Quaterniond::Identity(), {0, 0, 2}};
  const auto pose = ToProto({.result = result}, PosesOf::kBody, camera_from_body);
  EXPECT_FALSE(pose.has_local_from_camera());
  EXPECT_NEAR(pose.reckoned().local_from_camera().translation(2), 5, 1e-12);
  EXPECT_NEAR(pose.reckoned().covariance(0), 1e-2 + 4 * 1e-2, 1e-12) << "the body swings";
  EXPECT_DOUBLE_EQ(pose.reckoned().since_s(), 1.5);
}

TEST(PostedPoseTest, SaysWhereGravityPullsInTheFrameThatIsWanted) {
  TrackingResult result = Tracked();
  result.down = Down{Eigen::Vector3d::UnitY(), 0.01};
  // The body's z points up: along -y of the camera.
  const Rigid3d camera_from_body{
      Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX())),
      Eigen::Vector3d::Zero()};
  const auto pose = ToProto({.result = result}, PosesOf::kBody, camera_from_body);
  EXPECT_NEAR(pose.down().z(), -1, 1e-12);
  EXPECT_DOUBLE_EQ(pose.down().sigma_rad(), 0.01);
  EXPECT_FALSE(ToProto({.result = Tracked()}, PosesOf::kBody, camera_from_body).has_down());
}

TEST(PoseBoardTest, CountsChangesOfTheGlobalFrameAndKnowsWhatFollowsWhat) {
  PoseBoard board;
  std::vector<PostedPose> posted;
  bool ended = false;
  const uint64_t token =
      board.Add([&](const PostedPose& pose) { posted.push_back(pose); }, [&] { ended = true; });
  Similarity3d there = Similarity3d::Identity();
  board.Post(Tracked(), {}, 0);
  board.Post(Placed(Tracked(), there), {}, 0);
  board.Post(Placed(Tracked(), there), {}, 0);
  there.translation.x() = 1;
  board.Post(Placed(Lost(), there), {}, 0);
  board.Post(Placed(Tracked(), there), {}, 0);
  EXPECT_FALSE(ended);
  board.End();
  EXPECT_TRUE(ended);
  board.Remove(token);
  std::vector<uint64_t> epochs;
  std::vector<bool> follows;
  for (const PostedPose& pose : posted) {
    epochs.push_back(pose.global_epoch);
    follows.push_back(pose.follows_a_pose);
  }
  EXPECT_THAT(epochs, ElementsAre(0, 1, 1, 2, 2));
  EXPECT_THAT(follows, ElementsAre(false, true, true, true, false));
}

TEST(PostedPoseTest, NoVelocityAcrossAGapOrWithoutTime) {
  EXPECT_THAT(ToProto({.result = Tracked(), .follows_a_pose = false}, PosesOf::kRectifiedCamera,
                      std::nullopt)
                  .velocity(),
              IsEmpty());
  TrackingResult result = Tracked();
  result.motion->since_ns = 0;
  EXPECT_THAT(
      ToProto({.result = result, .follows_a_pose = true}, PosesOf::kRectifiedCamera, std::nullopt)
          .velocity(),
      IsEmpty());
}

}  // namespace
}  // namespace corbslam::services
