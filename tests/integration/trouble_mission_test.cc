// Tests what goes wrong on the road: each trouble in a simulated town or floor, in two fifths or
// three of the cameras' resolution, in one deterministic process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {
namespace {

using nlohmann::json;

constexpr char kBlock[] = "sim:city?seed=3&length=100&picture_scale=0.4";
// Options of another robot's pictures of the same way.
constexpr char kOther[] = "&phase=0.5&noise_seed=2";

std::string Block(const std::string& options) { return absl::StrCat(kBlock, options); }

json RunRobots(const std::vector<std::string>& sources) {
  std::vector<std::string> arguments = {"--pace", "step"};
  for (const std::string& source : sources) {
    arguments.insert(arguments.end(), {"--source", source});
  }
  return RunMission(arguments).report;
}

void ExpectOneMap(const json& report, double most_ate_m) {
  EXPECT_EQ(report["fused"]["islands"], 1);
  ASSERT_TRUE(report["fused"]["ate_m"].is_number());
  EXPECT_LE(report["fused"]["ate_m"], most_ate_m);
}

// Expects that no frame of one map is placed in another's frame.
void ExpectTwoMaps(const json& report, double most_ate_m) {
  EXPECT_EQ(report["fused"]["islands"], 2);
  EXPECT_EQ(report["overlaps"]["accepted"], 0);
  for (const json& robot : report["robots"]) {
    EXPECT_EQ(robot["lost"], 0) << robot["name"];
    EXPECT_LE(robot["ate_m"], most_ate_m) << robot["name"];
  }
}

// Two seconds in the dark cost their frames and nothing else.
TEST(TroubleMissionTest, ABlackoutIsSurvived) {
  const json report = RunRobots(
      {Block("&frames=:150"), Block(absl::StrCat("&frames=:150", kOther, "&blackout=5:2"))});
  ExpectOneMap(report, 0.3);
  const json& robot = report["robots"][1];
  EXPECT_GE(robot["lost"], 19);
  EXPECT_LE(robot["lost"], 40);
}

// A robot that is carried off begins a new map, which finds its place through the other robot's.
TEST(TroubleMissionTest, AKidnappedRobotIsFoundThroughTheOther) {
  const json report = RunRobots(
      {Block("&frames=:150"), Block(absl::StrCat("&frames=:120", kOther, "&kidnap=4:9"))});
  ExpectOneMap(report, 0.4);
  EXPECT_EQ(report["robots"][0]["lost"], 0);
  EXPECT_GE(report["robots"][1]["local_maps"], 2);
}

TEST(TroubleMissionTest, MovingCarsAreNoPartOfTheMap) {
  const std::string source = Block("&frames=:110&moving_cars=6");
  const json report = RunRobots({source, absl::StrCat(source, kOther)});
  ExpectOneMap(report, 0.3);
  for (const json& robot : report["robots"]) EXPECT_EQ(robot["lost"], 0) << robot["name"];
}

TEST(TroubleMissionTest, ARobotThatComesAnHourLateIsFused) {
  const json report = RunRobots(
      {Block("&frames=:110"), Block(absl::StrCat("&frames=:110", kOther, "&start_s=3600"))});
  ExpectOneMap(report, 0.3);
}

TEST(TroubleMissionTest, RobotsThatNeverMeetStayApart) {
  ExpectTwoMaps(RunRobots({Block("&frames=:110"),
                           "sim:city?seed=8&length=100&picture_scale=0.4&frames=:110"}),
                0.3);
}

// The way has the same few houses, over and over: a part of what is seen matches, and is wrong.
TEST(TroubleMissionTest, StreetsThatLookAlikeAreNotOne) {
  const std::string street = "sim:city?seed=5&length=400&look_alike=1&picture_scale=0.4&frames=";
  ExpectTwoMaps(RunRobots({street + ":110", street + "220:330"}), 0.5);
}

TEST(TroubleMissionTest, CorridorsThatLookAlikeAreNotOne) {
  const std::string floor = "sim:floor?seed=2&look_alike=1&picture_scale=0.6&frames=";
  ExpectTwoMaps(RunRobots({floor + ":300", floor + "600:900"}), 0.15);
}

TEST(TroubleMissionTest, WalkersOnAFloorMakeOneMap) {
  const Mission mission =
      RunMission({"--pace", "step", "--robots", "2", "--overlap", "20", "--source",
                  "sim:floor?seed=2&picture_scale=0.6&frames=:300"});
  ExpectOneMap(mission.report, 0.1);
}

}  // namespace
}  // namespace corbslam::tests
