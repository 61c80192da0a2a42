#include "client_agent/ros2/ros2_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

TEST(Ros2NamesTest, NamesAreResolvedAsRosDoes) {
  const auto names = Ros2Names::Make("visual_slam", {{"", "__ns", "/alpha"},
                                                     {"", "visual_slam/image_0", "/left/image_raw"},
                                                     {"", "/tf", "tf"},
                                                     {"other", "visual_slam/imu", "/wrong"},
                                                     {"visual_slam", "~/private", "mine"}});
  ASSERT_TRUE(names.ok()) << names.status();
  EXPECT_EQ(names->full_name(), "/alpha/visual_slam");
  EXPECT_EQ(names->Resolve("visual_slam/image_0"), "/left/image_raw");
  EXPECT_EQ(names->Resolve("/tf"), "/alpha/tf");
  EXPECT_EQ(names->Resolve("/tf_static"), "/tf_static");
  EXPECT_EQ(names->Resolve("visual_slam/imu"), "/alpha/visual_slam/imu");
  EXPECT_EQ(names->Resolve("~/private"), "/alpha/mine");
}

TEST(Ros2NamesTest, WithoutANamespace) {
  const auto names = Ros2Names::Make("visual_slam", {{"", "__node", "slam"}, {"", "__ns", "/"}});
  ASSERT_TRUE(names.ok()) << names.status();
  EXPECT_EQ(names->full_name(), "/slam");
  EXPECT_EQ(names->Resolve("a/b"), "/a/b");
}

TEST(Ros2NamesTest, BadNamesAreRefused) {
  for (const Ros2Rule& rule :
       {Ros2Rule{"", "__ns", "/al-pha"}, Ros2Rule{"", "__node", "a/b"}, Ros2Rule{"", "a", "/b//c"},
        Ros2Rule{"", "a", "/1b"}, Ros2Rule{"", "a", std::string(300, 'a')}}) {
    const absl::Status status = Ros2Names::Make("visual_slam", {rule}).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << rule.to;
    EXPECT_THAT(std::string(status.message()), HasSubstr(rule.from));
  }
}

TEST(Ros2NamesTest, NamesOnDds) {
  EXPECT_EQ(DdsTopic("/alpha/tf"), "rt/alpha/tf");
  EXPECT_EQ(DdsRequestTopic("/a/reset"), "rq/a/resetRequest");
  EXPECT_EQ(DdsResponseTopic("/a/reset"), "rr/a/resetReply");
  EXPECT_EQ(Ros2Topic("rt/a/b"), "/a/b");
  EXPECT_EQ(Ros2Topic("ros_discovery_info"), "");
  EXPECT_EQ(Ros2Type("sensor_msgs::msg::dds_::Image_"), "sensor_msgs/msg/Image");
}

}  // namespace
}  // namespace corbslam::client_agent
