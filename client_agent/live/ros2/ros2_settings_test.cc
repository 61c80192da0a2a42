#include "client_agent/live/ros2/ros2_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "client_agent/live/ros2/ros2_context.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

absl::StatusOr<Ros2Settings> Settings(const std::vector<Ros2Rule>& parameters,
                                      const std::vector<Ros2Rule>& remaps = {}) {
  Ros2Arguments arguments;
  arguments.parameters = parameters;
  const auto names = Ros2Names::Make("visual_slam", remaps);
  auto read = Ros2Parameters::Read(arguments, *names);
  return ReadRos2Settings(*names, *read);
}

TEST(Ros2SettingsTest, TopicsAndQualityOfService) {
  const auto settings = Settings(
      {{"", "image_transport", "compressed"},
       {"", "image_qos", "DEFAULT"},
       {"", "qos_overrides./left/image/compressed.subscription.reliability", "best_effort"}},
      {{"", "visual_slam/image_0", "/left/image"}, {"", "__ns", "/alpha"}});
  ASSERT_TRUE(settings.ok()) << settings.status();
  EXPECT_EQ(settings->images[0].topic, "/left/image/compressed");
  EXPECT_FALSE(settings->images[0].qos.reliable);
  EXPECT_EQ(settings->images[1].topic, "/alpha/visual_slam/image_1/compressed");
  EXPECT_TRUE(settings->images[1].qos.reliable);
  EXPECT_EQ(settings->infos[0].topic, "/alpha/visual_slam/camera_info_0");
  EXPECT_FALSE(Settings({})->images[0].qos.reliable);  // Sensors' data, unless somebody says so.
}

TEST(Ros2SettingsTest, DepthHasItsOwnTopics) {
  const auto settings =
      Settings({{"", "tracking_mode", "rgbd"}, {"", "depth_image_transport", "compressedDepth"}});
  ASSERT_TRUE(settings.ok()) << settings.status();
  EXPECT_EQ(settings->images[0].topic, "/visual_slam/image_0");
  EXPECT_EQ(settings->images[1].topic, "/visual_slam/depth_0/compressedDepth");
  EXPECT_EQ(settings->pair_within_ms, 20);
}

TEST(Ros2SettingsTest, MapIsLevelForALevelCamera) {
  const Rigid3d map_from_global = Settings({})->map_from_global;
  EXPECT_TRUE((map_from_global * Eigen::Vector3d(0, 0, 1)).isApprox(Eigen::Vector3d(1, 0, 0)));
  EXPECT_TRUE((map_from_global * Eigen::Vector3d(0, 1, 0)).isApprox(Eigen::Vector3d(0, 0, -1)));
}

TEST(Ros2SettingsTest, WhatIsWrongIsNamed) {
  const auto refused = [](const std::vector<Ros2Rule>& parameters) {
    return std::string(Settings(parameters).status().message());
  };
  EXPECT_THAT(refused({{"", "enable_slam_visualization", "true"}}),
              HasSubstr("there is no parameter enable_slam_visualization; there are"));
  EXPECT_THAT(refused({{"", "tracking_mode", "mono"}}), HasSubstr("one of stereo, rgbd"));
  EXPECT_THAT(refused({{"", "odom_frame", "map"}}), HasSubstr("must differ"));
  EXPECT_THAT(refused({{"", "base_frame", "''"}}), HasSubstr("base_frame is empty"));
  EXPECT_THAT(refused({{"", "map_from_global", "[1, 2]"}}), HasSubstr("6 numbers"));
  EXPECT_THAT(refused({{"", "depth_image_transport", "compressedDepth"}}), HasSubstr("rgbd"));
  EXPECT_THAT(refused({{"", "qos_overrides./nobody.subscription.depth", "3"}}),
              HasSubstr("/nobody"));
}

TEST(Ros2SettingsTest, TheEnvironmentIsChecked) {
  const auto names = Ros2Names::Make("visual_slam", {});
  const auto options = MakeNodeOptions({"42", "1", "", "humble"}, *names);
  ASSERT_TRUE(options.ok());
  EXPECT_EQ(options->domain, 42u);
  EXPECT_TRUE(options->only_this_host);
  EXPECT_TRUE(options->is_humble);
  EXPECT_THAT(std::string(MakeNodeOptions({"233", "", "", ""}, *names).status().message()),
              HasSubstr("ROS_DOMAIN_ID is '233'"));
  EXPECT_THAT(std::string(MakeNodeOptions({"", "", "OFF", ""}, *names).status().message()),
              HasSubstr("ROS_AUTOMATIC_DISCOVERY_RANGE is 'OFF'"));
}

}  // namespace
}  // namespace corbslam::client_agent
