// Tests a robot with an IMU that drives along a wall and can't see for a while.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <string>

#include "client_agent/agent/agent.h"
#include "client_agent/agent/testing/driven_wall.h"

namespace corbslam::client_agent {
namespace {

using ::testing::Contains;
using ::testing::Field;
using ::testing::IsEmpty;

constexpr int64_t kInterval_ns = 50'000'000;
constexpr int64_t kImuInterval_ns = 5'000'000;
constexpr int kSeen = 60;   // Frames before it gets dark.
constexpr int kAfter = 30;  // And after.
// The camera goes on by so much from frame to frame, and swings with it.
constexpr double kStep_px = 16;

ImuCalibration WallImu() {
  ImuCalibration imu;
  imu.noise = {1.7e-4, 2e-3, 1.9e-5, 3e-3};
  return imu;
}

class InertialAgentTest : public ::testing::Test {
 protected:
  std::unique_ptr<Agent> Make(bool has_imu) {
    AgentOptions options;
    options.deterministic = true;
    options.sensor.orb.features = 1000;
    StereoCalibration calibration = WallCalibration();
    if (has_imu) calibration.imu = WallImu();
    auto vocabulary =
        *Vocabulary::Load(std::string(CORBSLAM_SOURCE_DIR) + "/slam/vocabulary/data/corbslam.voc");
    return *Agent::Create(options, calibration, vocabulary, nullptr);
  }

  // Where the camera is, pixels of the wall.
  static double Place_px(int64_t time_ns) {
    const double frames = static_cast<double>(time_ns) / static_cast<double>(kInterval_ns);
    return kStep_px * frames + 30 * std::sin(0.2 * frames) + 30;
  }
  static double Place_m(int frame) {
    return kWallPixel_m * std::round(Place_px(frame * kInterval_ns));
  }

  SensorImages See(int frame, bool is_dark) {
    const int64_t time_ns = frame * kInterval_ns;
    SensorImages images =
        SeeWall(*wall_, static_cast<int>(std::lround(Place_px(time_ns))), time_ns);
    if (is_dark) {
      images.grey.setTo(3);
      images.right.setTo(3);
    }
    for (; felt_ns_ < time_ns + kImuInterval_ns; felt_ns_ += kImuInterval_ns) {
      images.imu.push_back(Feel(felt_ns_));
    }
    return images;
  }

  // The IMU's axes are the camera's: x along the wall, y down.
  ImuSample Feel(int64_t time_ns) {
    constexpr int64_t kAside_ns = 1'000'000;
    const double bend =
        Place_px(time_ns - kAside_ns) - 2 * Place_px(time_ns) + Place_px(time_ns + kAside_ns);
    ImuSample sample;
    sample.timestamp_ns = time_ns;
    sample.angular_velocity_rps = 0.002 * Draw() + Eigen::Vector3d(0.01, 0, 0);
    sample.specific_force_mps2 =
        Eigen::Vector3d(kWallPixel_m * bend / 1e-6, -kGravity_mps2, 0) + 0.03 * Draw();
    return sample;
  }
  Eigen::Vector3d Draw() { return {normal_(random_), normal_(random_), normal_(random_)}; }

  TrackingResult Track(Agent& agent, int frame, bool is_dark = false) {
    const auto result = agent.Track(See(frame, is_dark));
    EXPECT_TRUE(result.ok()) << result.status();
    return *result;
  }
  // Drives, sees nothing for so many frames, and goes on along a wall that it does not know.
  // Returns the last result.
  TrackingResult DriveThroughTheDark(Agent& agent, int dark) {
    int frame = 0;
    for (; frame < kSeen; ++frame) {
      EXPECT_EQ(Track(agent, frame).state, TrackingState::kTracking) << frame;
    }
    for (; frame < kSeen + dark; ++frame) reckoned_ = Track(agent, frame, true);
    TrackingResult last;
    wall_ = &unknown_;
    for (; frame < kSeen + dark + kAfter; ++frame) last = Track(agent, frame);
    end_m_ = Place_m(frame - 1) - Place_m(0);
    return last;
  }

  const cv::Mat known_ = LongWall(5, 200 * static_cast<int>(kStep_px) + 200);
  const cv::Mat unknown_ = LongWall(6, 200 * static_cast<int>(kStep_px) + 200);
  const cv::Mat* wall_ = &known_;
  std::mt19937_64 random_{3};
  std::normal_distribution<double> normal_;
  int64_t felt_ns_ = 0;
  TrackingResult reckoned_;  // The last one in the dark.
  double end_m_ = 0;
};

TEST_F(InertialAgentTest, LearnsWhichWayIsDownAndItsBias) {
  const auto agent = Make(true);
  TrackingResult last;
  for (int frame = 0; frame < kSeen; ++frame) last = Track(*agent, frame);
  const AgentStatus status = agent->GetStatus();
  ASSERT_TRUE(status.inertial.has_value());
  EXPECT_TRUE(status.inertial->is_ready);
  EXPECT_NEAR(status.inertial->biases.gyro_rps.x(), 0.01, 0.003);
  ASSERT_TRUE(last.down.has_value());
  EXPECT_GT(last.down->in_camera.y(), 0.999);
  EXPECT_THAT(status.input_findings, IsEmpty());
}

TEST_F(InertialAgentTest, GoesOnInOneLocalMapWhereTheDarkEndsBeforeAnotherPartOfTheWall) {
  const auto agent = Make(true);
  const TrackingResult last = DriveThroughTheDark(*agent, 10);
  const AgentStatus status = agent->GetStatus();
  EXPECT_EQ(status.local_maps, 1);
  EXPECT_EQ(status.bridged, 1);
  ASSERT_EQ(last.state, TrackingState::kTracking);
  EXPECT_NEAR(last.camera_from_local.Inverse().translation.x(), end_m_, 0.2);
  ASSERT_TRUE(reckoned_.reckoned.has_value());
  EXPECT_EQ(reckoned_.state, TrackingState::kLost);
  const double there_m = Place_m(kSeen + 9) - Place_m(0);
  const double sigma_m = std::sqrt(reckoned_.reckoned->covariance(0, 0));
  EXPECT_NEAR(reckoned_.reckoned->camera_from_local.Inverse().translation.x(), there_m,
              3 * sigma_m);
  EXPECT_LT(sigma_m, 0.1);
}

TEST_F(InertialAgentTest, WithoutAnImuAnotherLocalMapBeginsThere) {
  const auto agent = Make(false);
  const TrackingResult last = DriveThroughTheDark(*agent, 10);
  EXPECT_EQ(agent->GetStatus().local_maps, 2);
  EXPECT_FALSE(reckoned_.reckoned.has_value());
  EXPECT_FALSE(last.down.has_value());
  EXPECT_FALSE(agent->GetStatus().inertial.has_value());
}

TEST_F(InertialAgentTest, ComesBackAtOnceWhereTheMapStillShowsTheWall) {
  const auto agent = Make(true);
  int frame = 0;
  for (; frame < kSeen; ++frame) Track(*agent, frame);
  for (; frame < kSeen + 12; ++frame) Track(*agent, frame, true);
  const TrackingResult back = Track(*agent, frame);
  EXPECT_EQ(back.state, TrackingState::kTracking);
  EXPECT_FALSE(back.was_bridged);
  EXPECT_NEAR(back.camera_from_local.Inverse().translation.x(), Place_m(frame) - Place_m(0), 0.02);
}

TEST_F(InertialAgentTest, AnImuThatIsSilentIsToldAndTheRobotGoesOn) {
  const auto agent = Make(true);
  for (int frame = 0; frame < kSeen; ++frame) {
    SensorImages images = See(frame, false);
    images.imu.clear();
    const auto result = agent->Track(images);
    ASSERT_TRUE(result.ok());
    EXPECT_EQ(result->state, TrackingState::kTracking) << frame;
  }
  EXPECT_THAT(agent->GetStatus().input_findings,
              Contains(Field(&SourceFinding::code, "imu-missing")));
}

}  // namespace
}  // namespace corbslam::client_agent
