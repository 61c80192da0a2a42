#include "client_agent/live/ros2/ros2_camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "absl/synchronization/notification.h"
#include "client_agent/live/ros2/testing/ros2_driver.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

constexpr int64_t kStart_ns = 1'600'000'000'000'000'000;

// Calls `send` again and again until the rig is known.
template <typename Send>
absl::StatusOr<Rig> RigWhile(Ros2Camera& camera, const Send& send) {
  absl::Notification stop;
  std::atomic<bool> is_done = false;
  std::thread sender([&] {
    for (int i = 0; i < 100 && !is_done; ++i) {
      send();
      absl::SleepFor(absl::Milliseconds(100));
    }
    if (!is_done) stop.Notify();
  });
  absl::StatusOr<Rig> rig = camera.AwaitRig(stop);
  is_done = true;
  sender.join();
  return rig;
}

// Waits for the rig in vain while `send` does what a driver does: until the camera's problem has
// these words. Returns how the wait ended once it was stopped.
template <typename Send>
absl::Status AwaitProblem(Ros2Camera& camera, const Ros2Context& context, const std::string& words,
                          const Send& send) {
  absl::Notification stop;
  absl::Status ended;
  std::thread waiter([&] { ended = camera.AwaitRig(stop).status(); });
  EXPECT_TRUE(Within10s([&] {
    send();
    return context.camera().problem.find(words) != std::string::npos;
  })) << context.camera().problem;
  stop.Notify();
  waiter.join();
  return ended;
}

void SendPair(Ros2Driver& driver, int64_t stamp_ns, int64_t apart_ns = 0) {
  driver.SendPicture("/visual_slam/image_0", "left", stamp_ns, 10);
  driver.SendPicture("/visual_slam/image_1", "right", stamp_ns + apart_ns, 20);
}

void SendStereoInfo(Ros2Driver& driver) {
  driver.SendInfo("/visual_slam/camera_info_0", "left", 0);
  driver.SendInfo("/visual_slam/camera_info_1", "right", -5);
}

TEST(Ros2CameraTest, AStereoPairIsPlayed) {
  Ros2Driver driver;
  driver.SendTransform("/tf_static", "base_link", "left", {0.5, 0, 0.2}, kLatched);
  const auto context = TestContext();
  auto camera = Ros2Camera::Open(context, {});
  ASSERT_TRUE(camera.ok()) << camera.status();
  const auto rig = RigWhile(**camera, [&] {
    SendPair(driver, kStart_ns);
    SendStereoInfo(driver);
  });
  ASSERT_TRUE(rig.ok()) << rig.status();
  EXPECT_TRUE(rig->rectified);
  EXPECT_NEAR(rig->baseline_m, 0.1, 1e-12);
  EXPECT_EQ(rig->body_from_camera->translation.x(), 0.5);
  EXPECT_EQ(context->camera().camera_frame, "left");
  EXPECT_FALSE(context->camera().base_is_of_rig);

  auto stream =
      LiveStream::Open(*rig, *std::move(camera), {.name = "ros2", .pair_within_ns = 5'000'000});
  ASSERT_TRUE(stream.ok()) << stream.status();
  SendPair(driver, kStart_ns + 100'000'000, 3'000'000);
  const auto next = (*stream)->Next(absl::Now() + absl::Seconds(10));
  ASSERT_TRUE(next.ok()) << next.status();
  const auto* const frame = std::get_if<StreamFrame>(&*next);
  ASSERT_NE(frame, nullptr);
  EXPECT_EQ(frame->images.timestamp_ns, kStart_ns + 100'000'000);
  EXPECT_EQ(frame->images.grey.at<uint8_t>(5, 5), 10);
  EXPECT_EQ(frame->images.right.at<uint8_t>(5, 5), 20);
  // Without a time, and too far apart.
  SendPair(driver, 0);
  SendPair(driver, kStart_ns + 200'000'000, 9'000'000);
  EXPECT_TRUE(Within10s([&] { return (*stream)->camera_counts()->unpaired >= 1; }));
  EXPECT_THAT(context->camera().problem, HasSubstr("its header has no time"));
}

TEST(Ros2CameraTest, ExactTimesAreWantedWhereTheParameterSaysSo) {
  Ros2Driver driver;
  const auto context =
      TestContext({{"", "base_frame", "left"}, {"", "sync_matching_threshold_ms", "0"}});
  EXPECT_EQ(context->settings().pair_within_ms, 0);
  auto camera = Ros2Camera::Open(context, {});
  ASSERT_TRUE(camera.ok());
  const auto rig = RigWhile(**camera, [&] {
    SendPair(driver, kStart_ns);
    SendStereoInfo(driver);
  });
  ASSERT_TRUE(rig.ok()) << rig.status();
  auto stream = LiveStream::Open(*rig, *std::move(camera), {.name = "ros2", .pair_within_ns = 0});
  ASSERT_TRUE(stream.ok());
  SendPair(driver, kStart_ns + 100'000'000, 1);
  SendPair(driver, kStart_ns + 200'000'000);
  const auto next = (*stream)->Next(absl::Now() + absl::Seconds(10));
  ASSERT_TRUE(next.ok() && std::holds_alternative<StreamFrame>(*next));
  EXPECT_EQ(std::get<StreamFrame>(*next).images.timestamp_ns, kStart_ns + 200'000'000);
}

TEST(Ros2CameraTest, DepthInMetresIsPlayed) {
  Ros2Driver driver;
  const auto context = TestContext({{"", "base_frame", "rgb"}, {"", "tracking_mode", "rgbd"}});
  auto camera = Ros2Camera::Open(context, {});
  ASSERT_TRUE(camera.ok());
  const auto send = [&](int64_t stamp_ns) {
    driver.SendPicture("/visual_slam/image_0", "rgb", stamp_ns, 10);
    driver.SendPicture("/visual_slam/depth_0", "rgb", stamp_ns + 8'000'000, 3, "32FC1");
  };
  const auto rig = RigWhile(**camera, [&] {
    send(kStart_ns);
    driver.SendInfo("/visual_slam/camera_info_0", "rgb", 0);
  });
  ASSERT_TRUE(rig.ok()) << rig.status();
  EXPECT_EQ(rig->kind, RigKind::kRgbd);
  auto stream =
      LiveStream::Open(*rig, *std::move(camera), {.name = "ros2", .pair_within_ns = 20'000'000});
  ASSERT_TRUE(stream.ok()) << stream.status();
  send(kStart_ns + 100'000'000);
  const auto next = (*stream)->Next(absl::Now() + absl::Seconds(10));
  ASSERT_TRUE(next.ok() && std::holds_alternative<StreamFrame>(*next));
  EXPECT_EQ(std::get<StreamFrame>(*next).images.depth.at<uint16_t>(5, 5), 3000);
}

TEST(Ros2CameraTest, WhatIsMissingIsTold) {
  Ros2Driver driver;
  const auto context = TestContext();
  const auto camera = Ros2Camera::Open(context, {});
  ASSERT_TRUE(camera.ok());
  const absl::Status awaited =
      AwaitProblem(**camera, *context,
                   "nobody publishes /visual_slam/image_0 (sensor_msgs/msg/Image); published are "
                   "/left/image_raw: name one by -r visual_slam/image_0:=TOPIC",
                   [&] { driver.SendPicture("/left/image_raw", "left", kStart_ns, 10); });
  EXPECT_TRUE(absl::IsCancelled(awaited)) << awaited;
}

TEST(Ros2CameraTest, AMissingFrameIsTold) {
  Ros2Driver driver;
  const auto context = TestContext();
  const auto camera = Ros2Camera::Open(context, {});
  ASSERT_TRUE(camera.ok());
  AwaitProblem(**camera, *context, "/tf_static has no way from base_link to left", [&] {
    SendPair(driver, kStart_ns);
    SendStereoInfo(driver);
  }).IgnoreError();
}

TEST(Ros2CameraTest, PicturesThatNameNoFrameAreTold) {
  Ros2Driver driver;
  const auto context = TestContext();
  const auto camera = Ros2Camera::Open(context, {});
  ASSERT_TRUE(camera.ok());
  AwaitProblem(**camera, *context, "camera_optical_frame:=FRAME", [&] {
    driver.SendPicture("/visual_slam/image_0", "", kStart_ns, 10);
    driver.SendPicture("/visual_slam/image_1", "", kStart_ns, 20);
    SendStereoInfo(driver);
  }).IgnoreError();
}

TEST(Ros2CameraTest, ImuSamplesComeWithTheirFrame) {
  Ros2Driver driver;
  driver.SendTransform("/tf_static", "base_link", "left", {0, 0, 0}, kLatched);
  const auto context =
      TestContext({{"", "enable_imu_fusion", "true"}, {"", "imu_frame", "base_link"}});
  auto camera = Ros2Camera::Open(context, {});
  ASSERT_TRUE(camera.ok());
  const auto send_imu = [&](int64_t stamp_ns) {
    sensor_msgs_msg_dds__Imu_ imu = {};
    std::string frame = "imu";
    imu.header = {Ros2Time(stamp_ns), frame.data()};
    imu.orientation.w = 1;
    imu.linear_acceleration = {0, -9.81, 0};
    driver.Topic("/visual_slam/imu", sensor_msgs_msg_dds__Imu__desc, kSensorData).Publish(&imu);
  };
  const auto rig = RigWhile(**camera, [&] {
    SendPair(driver, kStart_ns);
    SendStereoInfo(driver);
    send_imu(kStart_ns);
  });
  ASSERT_TRUE(rig.ok()) << rig.status();
  ASSERT_TRUE(rig->imu.has_value());
  auto stream =
      LiveStream::Open(*rig, *std::move(camera), {.name = "ros2", .pair_within_ns = 5'000'000});
  ASSERT_TRUE(stream.ok()) << stream.status();
  for (int i = 1; i <= 10; ++i) send_imu(kStart_ns + i * 10'000'000);
  absl::SleepFor(absl::Milliseconds(300));
  SendPair(driver, kStart_ns + 100'000'000);
  const auto next = (*stream)->Next(absl::Now() + absl::Seconds(10));
  ASSERT_TRUE(next.ok() && std::holds_alternative<StreamFrame>(*next));
  const ImuSamples& samples = std::get<StreamFrame>(*next).images.imu;
  ASSERT_EQ(samples.size(), 10u);
  EXPECT_EQ(samples[9].specific_force_mps2.y(), -9.81);
}

}  // namespace
}  // namespace corbslam::client_agent
