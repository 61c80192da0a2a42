#include "client_agent/live/ros2/ros2_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client_agent/live/ros2/testing/ros2_driver.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

TEST(Ros2FramesTest, FixedFramesAreTakenAndMovingOnesAreNot) {
  Ros2Driver driver;
  driver.SendTransform("/tf_static", "base_link", "camera", {1, 0, 0}, kLatched);
  const auto context = TestContext();
  const Ros2Frames& frames = context->frames();
  // It was published before anybody listened.
  EXPECT_TRUE(Within10s([&] { return frames.TargetFromSource("base_link", "camera").ok(); }));
  EXPECT_EQ(frames.TargetFromSource("base_link", "camera")->translation.x(), 1);
  EXPECT_TRUE(Within10s([&] {
    driver.SendTransform("/tf", "base_link", "turret", {0, 1, 0}, kDefaultQos);
    return frames.OthersParentOf("turret") == "base_link";
  }));
  const absl::Status moves = frames.TargetFromSource("base_link", "turret").status();
  EXPECT_TRUE(absl::IsNotFound(moves));
  EXPECT_THAT(std::string(moves.message()), HasSubstr("what moves is not taken"));
}

}  // namespace
}  // namespace corbslam::client_agent
