#include "client_agent/ros2/ros2_parameters.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "client_agent/ros2/ros2_qos.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

class Ros2ParametersTest : public ::testing::Test {
 protected:
  absl::StatusOr<Ros2Parameters> Read(const std::string& yaml,
                                      const std::vector<Ros2Rule>& given = {}) {
    const std::string file = ::testing::TempDir() + "/ros2_parameters.yaml";
    std::ofstream(file) << yaml;
    Ros2Arguments arguments;
    arguments.parameter_files = {file};
    arguments.parameters = given;
    const auto names = Ros2Names::Make("visual_slam", {{"", "__ns", "/alpha"}});
    return Ros2Parameters::Read(arguments, *names);
  }
};

TEST_F(Ros2ParametersTest, FilesThenTheCommandLine) {
  auto parameters = Read(R"(
/**:
  ros__parameters: {map_frame: world, odom_frame: o}
/alpha/visual_slam:
  ros__parameters: {odom_frame: alpha/odom, qos_overrides: {/left: {subscription: {depth: 3}}}}
/beta/visual_slam:
  ros__parameters: {base_frame: wrong}
other:
  ros__parameters: {base_frame: wrong}
)",
                         {{"", "path_max_size", "7"}, {"other", "base_frame", "wrong"}});
  ASSERT_TRUE(parameters.ok()) << parameters.status();
  std::string map_frame;
  std::string odom_frame;
  std::string base_frame = "base_link";
  int path = 1;
  Ros2Qos qos;
  ASSERT_TRUE(parameters->Take("map_frame", map_frame).ok());
  ASSERT_TRUE(parameters->Take("odom_frame", odom_frame).ok());
  ASSERT_TRUE(parameters->Take("base_frame", base_frame).ok());
  ASSERT_TRUE(parameters->Take("path_max_size", path, 0, 10).ok());
  ASSERT_TRUE(TakeQosOverrides("/left", "subscription", *parameters, qos).ok());
  EXPECT_EQ(map_frame, "world");
  EXPECT_EQ(odom_frame, "alpha/odom");
  EXPECT_EQ(base_frame, "base_link");
  EXPECT_EQ(path, 7);
  EXPECT_EQ(qos.depth, 3);
  EXPECT_TRUE(parameters->CheckAllTaken().ok());
}

TEST_F(Ros2ParametersTest, WhatIsWrongIsNamed) {
  auto parameters = Read("/**: {ros__parameters: {a: maybe, b: 11, d: [1, x], e: 1, q: fast}}");
  ASSERT_TRUE(parameters.ok()) << parameters.status();
  bool a = false;
  int b = 0;
  std::vector<double> d;
  std::string q;
  EXPECT_THAT(std::string(parameters->Take("a", a).message()), HasSubstr("true or false"));
  EXPECT_THAT(std::string(parameters->Take("b", b, 0, 10).message()), HasSubstr("'11'"));
  EXPECT_THAT(std::string(parameters->Take("d", d, 2).message()), HasSubstr("2 numbers"));
  EXPECT_THAT(std::string(parameters->Take("q", q, {"slow"}).message()), HasSubstr("slow"));
  const absl::Status unknown = parameters->CheckAllTaken();
  EXPECT_THAT(std::string(unknown.message()), HasSubstr("there is no parameter e; there are a, b"));
  EXPECT_FALSE(Read("a: [").ok());
}

}  // namespace
}  // namespace corbslam::client_agent
