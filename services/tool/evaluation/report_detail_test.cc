#include "services/tool/evaluation/report_detail.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;

// Frames at 10 Hz; `lost` ones have no pose.
void AddPoses(int first, int last, const std::string& local_map, ServedTrajectory& trajectory) {
  for (int i = first; i <= last; ++i) {
    ServedPose& pose = trajectory.emplace_back();
    pose.timestamp_ns = int64_t{100'000'000} * i;
    pose.frame_from_camera.translation = {1.0 * i, 0, 0};
    pose.local_map = local_map;
  }
}

TEST(ComposeDetailTest, KnowsWhenARobotWasLost) {
  RobotPaths paths;
  paths.name = "alpha";
  AddPoses(10, 20, "1", paths.local);
  AddPoses(30, 40, "1", paths.local);
  AddPoses(60, 70, "2", paths.local);
  paths.global = paths.local;
  const ReportDetail detail = ComposeDetail({paths}, {}, "alpha", {});
  ASSERT_EQ(detail.robots.size(), 1u);
  const ReportDetail::Robot& robot = detail.robots[0];
  EXPECT_EQ(robot.begin_ns, 1'000'000'000);
  ASSERT_EQ(robot.tracked.size(), 3u);
  EXPECT_NEAR(robot.tracked[0].end_s, 1, 1e-9);
  EXPECT_NEAR(robot.tracked[1].begin_s, 2, 1e-9);
  EXPECT_NEAR(robot.tracked[2].begin_s, 5, 1e-9);
  EXPECT_THAT(robot.local_maps_s, ElementsAre(DoubleNear(5, 1e-9)));
}

TEST(ComposeDetailTest, CutsThePathWhereTrackingWasLost) {
  RobotPaths paths;
  paths.name = "alpha";
  AddPoses(10, 20, "1", paths.global);
  AddPoses(30, 40, "1", paths.global);
  paths.global[11].after_gap = true;
  const ReportDetail detail = ComposeDetail({paths}, {}, "alpha", {});
  ASSERT_EQ(detail.map.robots.size(), 1u);
  EXPECT_EQ(detail.map.robots[0].paths.size(), 2u);
}

TEST(ComposeDetailTest, TakesRobotsThatBroughtNothing) {
  const ReportDetail detail = ComposeDetail({RobotPaths{"alpha", {}, {}, {}}}, {}, "alpha", {});
  ASSERT_EQ(detail.robots.size(), 1u);
  EXPECT_TRUE(detail.robots[0].tracked.empty());
}

TEST(ComposeHeldTest, ShowsThoseThatHoldAnything) {
  client_agent::NearMap held;
  held.keyframes = {{{LocalMapId{1}, 0}, {}, false}, {{LocalMapId{2}, 0}, {}, true}};
  ServedMap map;
  map.keyframes = {{{LocalMapId{2}, 0}, {}, "alpha", {}}};
  const std::vector<RobotPaths> robots = {
      {"alpha", {}, {}, {}}, {"bravo", {}, {}, {}}, {"charlie", {}, {}, {}}};
  const auto pictures = ComposeHeld(robots, {std::nullopt, held, client_agent::NearMap()}, map);
  ASSERT_EQ(pictures.size(), 1u);
  EXPECT_EQ(pictures[0].robot, "bravo");
  ASSERT_EQ(pictures[0].map.robots.size(), 2u);
  EXPECT_EQ(pictures[0].map.robots[0].name, "alpha");
  EXPECT_TRUE(pictures[0].map.robots[1].is_own);
  EXPECT_TRUE(pictures[0].nearer.has_value());
}

}  // namespace
}  // namespace corbslam::services
