// Tests two robots in a simulated town, with no file in between.
#include <gtest/gtest.h>

#include <string>

#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {
namespace {

using nlohmann::json;

// The way goes round one block, in two fifths of the cameras' resolution.
constexpr char kBlock[] = "sim:city?seed=3&length=100&picture_scale=0.4&frames=:110";

// The robots have different pictures: half a frame apart, in other light, with other noise.
TEST(SimulatedMissionTest, TwoRobotsMakeOneMapOfATown) {
  const Mission mission = RunMission({"--source", kBlock, "--robots", "2", "--overlap", "20",
                                      "--perturb", "2:phase=0.5,exposure=0.85,noise_seed=2"});
  const json& report = mission.report;
  ASSERT_EQ(report["robots"].size(), 2u);
  for (const json& robot : report["robots"]) {
    EXPECT_EQ(robot["lost"], 0) << robot["name"];
    EXPECT_EQ(robot["dropped"], 0) << robot["name"];
    EXPECT_LE(robot["ate_m"], 0.25) << robot["name"];
  }
  EXPECT_EQ(report["fused"]["islands"], 1);
  EXPECT_EQ(report["fused"]["robots"], 2);
  EXPECT_LE(report["fused"]["ate_m"], 0.25);
}

// Small pictures full of corners, of streets with the same kinds of things in them: wrong places
// were taken for overlaps here.
TEST(SimulatedMissionTest, PlacesThatLookAlikeAreNotTheSame) {
  const Mission mission =
      RunMission({"--source", "sim:city?seed=3&length=160&picture_scale=0.4&frames=:149",
                  "--robots", "2", "--overlap", "20", "--pace", "step"});
  const json& fused = mission.report["fused"];
  EXPECT_EQ(fused["islands"], 1);
  ASSERT_TRUE(fused["ate_m"].is_number());
  EXPECT_LE(fused["ate_m"], 0.4);
}

}  // namespace
}  // namespace corbslam::tests
