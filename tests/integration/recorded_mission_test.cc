// Tests the accuracy bars of the project on the shared recordings, in the deterministic run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {
namespace {

using nlohmann::json;

std::string Kitti() { return absl::StrCat("kitti:", *RecordingsFolder(), "/kitti_00_first201"); }
std::string Tum() { return absl::StrCat("tum:", *RecordingsFolder(), "/tum_fr1_xyz_15hz"); }

void ExpectFused(const Mission& mission, double max_ate_m, double max_ate_from_frame_m) {
  const json& fused = mission.report["fused"];
  EXPECT_EQ(fused["islands"], 1);
  ASSERT_TRUE(fused["ate_m"].is_number()) << mission.report.dump(2);
  EXPECT_LE(fused["ate_m"], max_ate_m);
  EXPECT_LE(fused["ate_from_frame_m"], max_ate_from_frame_m);
  for (const json& robot : mission.report["robots"]) EXPECT_EQ(robot["lost"], 0) << robot["name"];
}

TEST(RecordedMissionTest, KittiOneRobot) {
  SKIP_WITHOUT_RECORDINGS();
  const Mission mission = RunMission({"--source", Kitti(), "--robots", "1", "--pace", "step"});
  ExpectFused(mission, 0.36, 0.215);
  EXPECT_EQ(mission.report["robots"][0]["tracked"], 201);
}

TEST(RecordedMissionTest, KittiTwoRobots) {
  SKIP_WITHOUT_RECORDINGS();
  ExpectFused(RunMission({"--source", Kitti(), "--robots", "2", "--pace", "step"}), 0.37, 0.23);
}

TEST(RecordedMissionTest, KittiInterleavedDarkAndNoisy) {
  SKIP_WITHOUT_RECORDINGS();
  ExpectFused(RunMission({"--source", Kitti(), "--robots", "2", "--pace", "step", "--split",
                          "interleaved", "--perturb", "2:gamma=0.8,noise=4"}),
              1.3 * 0.37, 1.3 * 0.23);
}

TEST(RecordedMissionTest, KittiThreeRobots) {
  SKIP_WITHOUT_RECORDINGS();
  ExpectFused(RunMission({"--source", Kitti(), "--robots", "3", "--pace", "step"}), 0.38, 0.24);
}

TEST(RecordedMissionTest, KittiSecondRobotTracksAgainstTheFirstOnesMap) {
  SKIP_WITHOUT_RECORDINGS();
  const Mission mission =
      RunMission({"--source", Kitti(), "--robots", "2", "--pace", "step", "--sequential"});
  ExpectFused(mission, 0.37, 0.23);
  EXPECT_GT(mission.report["robots"][1]["shared"]["keyframes_held"], 0);
  EXPECT_GE(mission.report["robots"][1]["shared"]["points_matched_percent"], 20);
}

TEST(RecordedMissionTest, TumOneRobot) {
  SKIP_WITHOUT_RECORDINGS();
  ExpectFused(RunMission({"--source", Tum(), "--robots", "1", "--pace", "step"}), 0.011, 0.011);
}

TEST(RecordedMissionTest, TumTwoRobots) {
  SKIP_WITHOUT_RECORDINGS();
  ExpectFused(RunMission({"--source", Tum(), "--robots", "2", "--pace", "step"}), 0.012, 0.012);
}

TEST(RecordedMissionTest, TumThreeRobots) {
  SKIP_WITHOUT_RECORDINGS();
  ExpectFused(RunMission({"--source", Tum(), "--robots", "3", "--pace", "step"}), 0.013, 0.013);
}

TEST(RecordedMissionTest, TumTwoRobotsOneBackwards) {
  SKIP_WITHOUT_RECORDINGS();
  ExpectFused(
      RunMission({"--source", Tum(), "--robots", "2", "--pace", "step", "--perturb", "2:reverse"}),
      1.3 * 0.012, 1.3 * 0.012);
}

TEST(RecordedMissionTest, DifferentPlacesStayApart) {
  SKIP_WITHOUT_RECORDINGS();
  const Mission mission = RunMission({"--source", absl::StrCat(Kitti(), "?frames=0:60"), "--source",
                                      absl::StrCat(Tum(), "?frames=0:120"), "--pace", "step"});
  EXPECT_EQ(mission.report["fused"]["islands"], 2);
  EXPECT_EQ(mission.report["overlaps"]["accepted"], 0);
  EXPECT_TRUE(mission.report["fused"]["ate_m"].is_null());
}

TEST(RecordedMissionTest, EurocIsRectifiedAndTracked) {
  SKIP_WITHOUT_RECORDINGS();
  const Mission mission =
      RunMission({"--source", absl::StrCat("euroc:", *RecordingsFolder(), "/euroc_v1_01_first40"),
                  "--robots", "1", "--pace", "step"});
  EXPECT_EQ(mission.report["robots"][0]["tracked"], 40);
  EXPECT_LE(mission.report["robots"][0]["ate_m"], 0.02);
}

}  // namespace
}  // namespace corbslam::tests
