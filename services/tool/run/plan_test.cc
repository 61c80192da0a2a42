#include "services/tool/run/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "services/simulated_source/simulated_source.h"

namespace corbslam::services {

using client_agent::FormatSourceSpec;
using client_agent::FrameSelection;
using client_agent::ParseSourceSpec;
using client_agent::SelectFrames;

namespace {

[[maybe_unused]] const bool registered = RegisterSimulatedSources();

using Range = std::pair<size_t, size_t>;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<Range> Ranges(size_t count, size_t robots, size_t overlap) {
  std::vector<Range> ranges;
  for (const FrameSelection& part : SplitFrames(0, count, {robots, overlap, SplitMode::kHalves})) {
    ranges.push_back({part.first, *part.last});
  }
  return ranges;
}

TEST(SplitFramesTest, IsThePapersForTwo) {
  EXPECT_THAT(Ranges(201, 2, 20), ElementsAre(Range(0, 120), Range(80, 200)));
  EXPECT_THAT(Ranges(396, 2, 20), ElementsAre(Range(0, 217), Range(178, 395)));
}

TEST(SplitFramesTest, ReachesBothWaysInTheMiddle) {
  EXPECT_THAT(Ranges(201, 3, 20), ElementsAre(Range(0, 86), Range(47, 153), Range(114, 200)));
}

TEST(SplitFramesTest, StaysWithinTheSequence) {
  EXPECT_THAT(Ranges(10, 1, 20), ElementsAre(Range(0, 9)));
  EXPECT_THAT(Ranges(10, 2, 20), ElementsAre(Range(0, 9), Range(0, 9)));
  EXPECT_TRUE(SplitFrames(5, 5, {}).empty());
}

TEST(PlanRobotsTest, RecordedTruthsMayBeInOneFrame) {
  PlanOptions options;
  for (const char* text : {"tum:/desk", "tum:/desk2?truth_frame=hall", "sim:city?seed=7"}) {
    options.sources.push_back(*ParseSourceSpec(text));
  }
  const auto frames = [&options] {
    std::vector<std::string> names;
    const auto robots = PlanRobots(options);
    EXPECT_TRUE(robots.ok()) << robots.status();
    for (const RobotPlan& robot : *robots) names.push_back(robot.source.truth_frame);
    return names;
  };
  EXPECT_THAT(frames(), ElementsAre("", "hall", ""));
  options.is_truth_shared = true;
  EXPECT_THAT(frames(), ElementsAre("shared", "hall", ""));
}

TEST(SplitFramesTest, InterleavedRobotsShareNoFrame) {
  const std::vector<FrameSelection> parts = SplitFrames(0, 201, {2, 20, SplitMode::kInterleaved});
  EXPECT_THAT(SelectFrames(parts[0], 201), ::testing::Each(::testing::Truly([](size_t frame) {
                return frame % 2 == 0 && frame <= 120;
              })));
  EXPECT_THAT(SelectFrames(parts[1], 201), ::testing::Each(::testing::Truly([](size_t frame) {
                return frame % 2 == 1 && frame >= 80;
              })));
}

TEST(PlanRobotsTest, GivesEachOfSeveralSourcesARobot) {
  PlanOptions options;
  options.sources = {*ParseSourceSpec("kitti:a"), *ParseSourceSpec("tum:b")};
  options.perturbations[2] = "gamma=0.8,reverse";
  const absl::StatusOr<std::vector<RobotPlan>> robots = PlanRobots(options);
  ASSERT_TRUE(robots.ok()) << robots.status();
  ASSERT_EQ(robots->size(), 2u);
  EXPECT_EQ((*robots)[0].name, "alpha");
  EXPECT_EQ((*robots)[1].name, "bravo");
  EXPECT_EQ(FormatSourceSpec((*robots)[1].source), "tum:b?reverse=1&gamma=0.8");
}

TEST(PlanRobotsTest, SplitsASimulation) {
  PlanOptions options;
  options.sources = {*ParseSourceSpec("sim:city?seed=3&length=160")};
  options.perturbations[2] = "phase=0.5,turned,noise_seed=9";
  const absl::StatusOr<std::vector<RobotPlan>> robots = PlanRobots(options);
  ASSERT_TRUE(robots.ok()) << robots.status();
  ASSERT_EQ(robots->size(), 2u);
  EXPECT_EQ((*robots)[0].source.selection.first, 0u);
  EXPECT_TRUE(FindSimulation((*robots)[1].source)->turned);
  EXPECT_EQ(FindSimulation((*robots)[1].source)->seed, 3u);
  // The parts overlap in place.
  EXPECT_LT((*robots)[1].source.selection.first, *(*robots)[0].source.selection.last);
}

TEST(PlanRobotsTest, DoesNotSplitAPartAgain) {
  PlanOptions options;
  options.sources = {*ParseSourceSpec("sim:city?seed=3&length=160&robot=1/3")};
  EXPECT_EQ(PlanRobots(options).status().code(), absl::StatusCode::kInvalidArgument);
  options.split.robots = 1;
  EXPECT_TRUE(PlanRobots(options).ok());
}

// The source frames=:99 has 100 frames.
TEST(PlanRobotsTest, LeavesEachRobotTenFramesOfItsOwnShare) {
  PlanOptions options;
  options.sources = {*ParseSourceSpec("sim:city?seed=3&length=160&frames=:99")};
  for (const auto& [mode, most] :
       {std::pair(SplitMode::kHalves, size_t{10}), std::pair(SplitMode::kInterleaved, size_t{3})}) {
    options.split.mode = mode;
    options.split.robots = most;
    EXPECT_TRUE(PlanRobots(options).ok()) << PlanRobots(options).status();
    options.split.robots = most + 1;
    const absl::Status status = PlanRobots(options).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(status.message()),
                AllOf(HasSubstr(absl::StrCat(most + 1, " robots share 100 frames")),
                      HasSubstr(absl::StrCat("at most ", most, " can"))));
  }
}

TEST(PlanRobotsTest, OneRobotTakesAShortSequence) {
  PlanOptions options;
  options.sources = {*ParseSourceSpec("sim:city?seed=3&length=160&frames=:4")};
  options.split.robots = 1;
  EXPECT_TRUE(PlanRobots(options).ok()) << PlanRobots(options).status();
}

TEST(PlanRobotsTest, RefusesAPerturbationOfNobody) {
  PlanOptions options;
  options.sources = {*ParseSourceSpec("kitti:a"), *ParseSourceSpec("tum:b")};
  options.perturbations[3] = "gamma=0.8";
  EXPECT_EQ(PlanRobots(options).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(ParsePerturbationTest, NeedsARobotAndOptions) {
  EXPECT_EQ(ParsePerturbation("2:gamma=0.8,noise=4,reverse")->second, "gamma=0.8,noise=4,reverse");
  EXPECT_EQ(ParsePerturbation("2:gamma=0.8")->first, 2u);
  for (const char* text : {"", "2", "2:", "x:gamma=1"}) {
    EXPECT_FALSE(ParsePerturbation(text).ok()) << text;
  }
}

TEST(RobotNameTest, GoesOnBeyondTheAlphabet) {
  EXPECT_EQ(RobotName(2), "charlie");
  EXPECT_EQ(RobotName(26), "robot27");
}

}  // namespace
}  // namespace corbslam::services
