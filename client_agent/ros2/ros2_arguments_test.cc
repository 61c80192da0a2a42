#include "client_agent/ros2/ros2_arguments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(Ros2ArgumentsTest, RosPartIsTakenOutOfTheLine) {
  const auto parsed =
      ParseRos2Arguments({"corbslam_ros2", "--agent", "alpha", "--ros-args", "-r", "__ns:=/alpha",
                          "--remap", "visual_slam:a:=/b", "-p", "map_frame:=world", "--params-file",
                          "p.yaml", "--log-level", "info", "--", "--mission", "lab"});
  ASSERT_TRUE(parsed.ok()) << parsed.status();
  EXPECT_THAT(parsed->others, ElementsAre("corbslam_ros2", "--agent", "alpha", "--mission", "lab"));
  ASSERT_EQ(parsed->remaps.size(), 2u);
  EXPECT_EQ(parsed->remaps[0].from, "__ns");
  EXPECT_EQ(parsed->remaps[0].to, "/alpha");
  EXPECT_EQ(parsed->remaps[1].node, "visual_slam");
  EXPECT_EQ(parsed->remaps[1].from, "a");
  ASSERT_EQ(parsed->parameters.size(), 1u);
  EXPECT_EQ(parsed->parameters[0].to, "world");
  EXPECT_THAT(parsed->parameter_files, ElementsAre("p.yaml"));
  EXPECT_THAT(parsed->without_effect, ElementsAre("--log-level info"));
}

TEST(Ros2ArgumentsTest, WhatIsWrongIsNamed) {
  const auto refused = [](const std::vector<std::string>& arguments) {
    return std::string(ParseRos2Arguments(arguments).status().message());
  };
  EXPECT_THAT(refused({"x", "--ros-args", "-r", "a=b"}), HasSubstr("-r a=b"));
  EXPECT_THAT(refused({"x", "--ros-args", "-r", "a:="}), HasSubstr("wants FROM:=TO"));
  EXPECT_THAT(refused({"x", "--ros-args", "-p"}), HasSubstr("value is missing"));
  EXPECT_THAT(refused({"x", "--ros-args", "--agent", "alpha"}), HasSubstr("--agent"));
  EXPECT_THAT(refused({"x", "--ros-args", "-e", "/secret"}), HasSubstr("-e"));
}

}  // namespace
}  // namespace corbslam::client_agent
