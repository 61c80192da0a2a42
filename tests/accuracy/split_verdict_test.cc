#include "tests/accuracy/split_verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace corbslam::tests {
namespace {

using ::testing::DoubleEq;
using ::testing::HasSubstr;
using ::testing::Optional;

SplitRun RunOf(double ate_m, int islands = 1) {
  SplitRun run;
  run.islands = islands;
  run.ate_m = ate_m;
  return run;
}

RobotOfRun RobotOf(std::optional<double> local_ate_m, std::optional<double> global_ate_m) {
  RobotOfRun robot;
  robot.name = "alpha";
  robot.local_ate_m = local_ate_m;
  robot.global_ate_m = global_ate_m;
  return robot;
}

TEST(SplitVerdictTest, MediansAreCompared) {
  const auto verdict =
      Judge("two", "one", {RunOf(9), RunOf(1.05), RunOf(1)}, {RunOf(0.5), RunOf(1), RunOf(7)}, 3);
  EXPECT_TRUE(verdict.IsComplete());
  EXPECT_THAT(verdict.ate_m, Optional(DoubleEq(1.05)));
  EXPECT_THAT(verdict.Ratio(), Optional(DoubleEq(1.05)));
  EXPECT_TRUE(verdict.IsMet());
  EXPECT_FALSE(Judge("two", "one", {RunOf(1.06)}, {RunOf(1)}, 1).IsMet());
}

TEST(SplitVerdictTest, OfAnEvenNumberTheMiddleTwoCount) {
  EXPECT_THAT(Judge("two", "one", {RunOf(1), RunOf(4), RunOf(2), RunOf(9)}, {}, 4).ate_m,
              Optional(DoubleEq(3)));
}

TEST(SplitVerdictTest, OneRunInSeveralIslandsIsEnoughToMiss) {
  const auto verdict = Judge("two", "one", {RunOf(1), RunOf(1, 2)}, {RunOf(1), RunOf(1)}, 2);
  EXPECT_EQ(verdict.most_islands, 2);
  EXPECT_FALSE(verdict.IsMet());
}

TEST(SplitVerdictTest, ARunWithoutErrorLeavesNoMedian) {
  SplitRun apart = RunOf(1, 2);
  apart.ate_m.reset();
  const auto verdict = Judge("two", "one", {RunOf(1), apart}, {RunOf(1), RunOf(1)}, 2);
  EXPECT_EQ(verdict.ate_m, std::nullopt);
  EXPECT_FALSE(verdict.IsMet());
}

TEST(SplitVerdictTest, IsIncompleteWhileEitherHasTooFewRuns) {
  EXPECT_FALSE(Judge("two", "one", {RunOf(1)}, {RunOf(1), RunOf(1)}, 2).IsComplete());
  EXPECT_FALSE(Judge("two", "one", {RunOf(1), RunOf(1)}, {RunOf(1)}, 2).IsComplete());
}

TEST(SplitVerdictTest, CountsRunsWhoseGlobalLayerIsTheWorseOne) {
  std::vector<SplitRun> runs(3, RunOf(1));
  runs[0].robots = {RobotOf(1.0, 0.9)};
  runs[1].robots = {RobotOf(1.0, 1.1)};
  runs[2].robots = {RobotOf(std::nullopt, 5)};  // The robot has several local maps.
  const auto verdict = Judge("two", "one", runs, {}, 3);
  ASSERT_EQ(verdict.robots.size(), 1u);
  EXPECT_EQ(verdict.robots[0].runs, 2);
  EXPECT_EQ(verdict.robots[0].worse_runs, 1);
  EXPECT_THAT(verdict.robots[0].global_ate_m, Optional(DoubleEq(1.0)));
  EXPECT_TRUE(verdict.robots[0].IsMet());
}

TEST(SplitVerdictTest, AWorseGlobalLayerMissesTheBarThoughTheMapMeetsItsOwn) {
  std::vector<SplitRun> runs = {RunOf(1)};
  runs[0].robots = {RobotOf(1.0, 0.9), RobotOf(1.0, 1.01)};
  const auto verdict = Judge("two", "one", runs, {RunOf(1)}, 1);
  EXPECT_TRUE(verdict.IsMapMet());
  EXPECT_FALSE(verdict.IsMet());
}

class SplitRunsTest : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::remove_all(folder_); }
  void Write(const std::string& run, const std::string& report) {
    std::filesystem::create_directories(folder_ + "/two/" + run);
    std::ofstream(folder_ + "/two/" + run + "/report.json") << report;
  }

  const std::string folder_ = ::testing::TempDir() + "/split_runs";
};

constexpr char kReport[] = R"({"version": "1", "command": "corbslam run",
  "fused": {"islands": 1, "keyframes": 7, "ate_m": 0.5, "ate_from_frame_m": null,
            "ate_without_scale_m": 0.4, "scale": 0.99},
  "robots": [{"name": "alpha", "lost": 0, "local_maps": 1, "ate_m": 0.25, "ate_global_m": 0.2},
             {"name": "bravo", "lost": 3, "local_maps": 2, "ate_m": 0.3, "ate_global_m": 0.3}]})";

TEST_F(SplitRunsTest, ReadsReportsInTheOrderOfTheirNumbers) {
  for (const char* run : {"10", "9"}) Write(run, kReport);
  std::filesystem::create_directories(folder_ + "/two/11");  // This run was stopped before its end.
  const auto runs = ReadRuns(folder_, "two");
  ASSERT_TRUE(runs.ok()) << runs.status();
  ASSERT_EQ(runs->size(), 2u);
  EXPECT_EQ((*runs)[0].folder, "9");
  EXPECT_EQ((*runs)[1].folder, "10");
  EXPECT_THAT((*runs)[0].ate_m, Optional(DoubleEq(0.5)));
  EXPECT_EQ((*runs)[0].ate_from_frame_m, std::nullopt);
  EXPECT_THAT((*runs)[0].ate_without_scale_m, Optional(DoubleEq(0.4)));
  EXPECT_THAT((*runs)[0].robots[0].local_ate_m, Optional(DoubleEq(0.25)));
  EXPECT_EQ((*runs)[0].robots[1].local_ate_m, std::nullopt);
}

TEST_F(SplitRunsTest, ReadsReportsFromBeforeTheErrorWithoutScale) {
  Write("1", R"({"version": "1", "command": "corbslam run", "robots": [],
    "fused": {"islands": 1, "keyframes": 7, "ate_m": 0.5, "ate_from_frame_m": 0.4}})");
  const auto runs = ReadRuns(folder_, "two");
  ASSERT_TRUE(runs.ok()) << runs.status();
  EXPECT_EQ((*runs)[0].ate_without_scale_m, std::nullopt);
}

TEST_F(SplitRunsTest, NamesTheReportThatIsDamaged) {
  Write("1", R"({"version": "1"})");
  const auto runs = ReadRuns(folder_, "two");
  EXPECT_EQ(runs.status().code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(runs.status().message(), HasSubstr("two/1/report.json"));
}

TEST_F(SplitRunsTest, NoFolderIsNoRun) { EXPECT_TRUE(ReadRuns(folder_, "three")->empty()); }

}  // namespace
}  // namespace corbslam::tests
