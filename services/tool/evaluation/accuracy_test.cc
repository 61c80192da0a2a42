#include "services/tool/evaluation/accuracy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "services/simulated_source/simulated_source.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/text_file.h"

namespace corbslam::services {

using client_agent::FramesOf;
using client_agent::ParseSourceSpec;
using client_agent::SourceSpec;

namespace {

[[maybe_unused]] const bool registered = RegisterSimulatedSources();

namespace fs = std::filesystem;
using ::testing::DoubleNear;
using ::testing::Optional;

constexpr int kFrames = 40;

// Returns the true pose at frame i of a bent road, at 10 Hz.
StampedPose TruthAt(int i) {
  StampedPose pose;
  pose.timestamp_ns = int64_t{100'000'000} * i;
  pose.world_from_camera.translation = {0.02 * i * i, 0.3 * std::sin(0.3 * i), 1.0 * i};
  return pose;
}

// Makes a KITTI folder of kFrames frames. Nothing reads its pictures but the first.
SourceSpec MakeSequence(const std::string& name) {
  const fs::path directory = fs::path(::testing::TempDir()) / ("accuracy_" + name);
  fs::create_directories(directory / "image_0");
  fs::create_directories(directory / "image_1");
  std::ofstream(directory / "calib.txt")
      << "P0: 50 0 20 0 0 50 15 0 0 0 1 0\nP1: 50 0 20 -25 0 50 15 0 0 0 1 0\n";
  const std::string picture = (directory / "picture.png").string();
  cv::imwrite(picture, cv::Mat::zeros(30, 40, CV_8UC1));
  for (int i = 0; i < kFrames; ++i) {
    for (const int camera : {0, 1}) {
      fs::copy_file(picture, directory / absl::StrFormat("image_%d/%06d.png", camera, i),
                    fs::copy_options::overwrite_existing);
    }
  }
  std::ofstream times(directory / "times.txt");
  Trajectory truth;
  for (int i = 0; i < kFrames; ++i) {
    truth.push_back(TruthAt(i));
    times << FormatSeconds(TruthAt(i).timestamp_ns) << "\n";
  }
  EXPECT_TRUE(WriteKittiTrajectory(truth, (directory / "poses.txt").string()).ok());
  return *ParseSourceSpec(absl::StrCat("kitti:", directory.string()));
}

// Returns the poses of frames first to last, seen from another frame and `offset` beside the truth.
ServedTrajectory MakePoses(int first, int last, const Eigen::Vector3d& offset) {
  const Rigid3d other_from_world{Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5), {1, 2, 3}};
  ServedTrajectory trajectory;
  for (int i = first; i <= last; ++i) {
    StampedPose truth = TruthAt(i);
    truth.world_from_camera.translation += offset;
    trajectory.push_back(
        {truth.timestamp_ns, other_from_world * truth.world_from_camera, "missions/m/localMaps/1"});
  }
  return trajectory;
}

RobotPaths MakeRobot(const SourceSpec& source, int first, int last, const Eigen::Vector3d& offset,
                     bool in_global) {
  const ServedTrajectory poses = MakePoses(first, last, offset);
  return {"robot", source, poses, in_global ? poses : ServedTrajectory{}};
}

TEST(ComputeAccuracyTest, AlignsEachRobotAndAllTogether) {
  const SourceSpec source = MakeSequence("two");
  const absl::StatusOr<Accuracy> accuracy = ComputeAccuracy(
      {MakeRobot(source, 0, 39, {0, 0, 0}, true), MakeRobot(source, 0, 39, {0, 4, 0}, true)}, 10,
      Alignment::kSe3);
  ASSERT_TRUE(accuracy.ok()) << accuracy.status();
  EXPECT_THAT(accuracy->robots[0].ate_m, Optional(DoubleNear(0, 1e-6)));
  EXPECT_THAT(accuracy->robots[1].ate_m, Optional(DoubleNear(0, 1e-6)));
  EXPECT_THAT(accuracy->robots[1].ate_global_m, Optional(DoubleNear(0, 1e-6)));
  ASSERT_TRUE(accuracy->fused.all.has_value());
  EXPECT_NEAR(accuracy->fused.all->rmse_m, 2, 1e-6);
  EXPECT_EQ(accuracy->fused.all->poses, 80u);
  ASSERT_TRUE(accuracy->fused.from_frame.has_value());
  EXPECT_EQ(accuracy->fused.from_frame->poses, 60u);
  // Each pose is 2 m off under the alignment of all, which is the error of all.
  for (const RobotAccuracy& robot : accuracy->robots) {
    EXPECT_TRUE(robot.is_profile_global);
    ASSERT_EQ(robot.profile.size(), 40u);
    for (const PoseError& error : robot.profile) EXPECT_NEAR(error.error_m, 2, 1e-6);
  }
}

TEST(ComputeAccuracyTest, AlignsTheProfileOfARobotApartByItself) {
  const absl::StatusOr<Accuracy> accuracy = ComputeAccuracy(
      {MakeRobot(MakeSequence("apart"), 0, 39, {0, 4, 0}, false)}, 10, Alignment::kSe3);
  ASSERT_TRUE(accuracy.ok()) << accuracy.status();
  EXPECT_FALSE(accuracy->robots[0].is_profile_global);
  ASSERT_EQ(accuracy->robots[0].profile.size(), 40u);
  EXPECT_NEAR(accuracy->robots[0].profile[7].error_m, 0, 1e-6);
  EXPECT_NEAR(
      (accuracy->robots[0].profile[7].aligned - TruthAt(7).world_from_camera.translation).norm(), 0,
      1e-6);
}

// The road is straight and 160 m long; an estimate of it is one percent too long.
TEST(ComputeAccuracyTest, MeasuresEachRobotsRelativeErrorOfItsOwnTrajectory) {
  const SourceSpec source = MakeSequence("relative");
  Trajectory truth;
  ServedTrajectory estimate;
  for (int i = 0; i < kFrames; ++i) {
    StampedPose& pose = truth.emplace_back();
    pose.timestamp_ns = TruthAt(i).timestamp_ns;
    pose.world_from_camera.translation = {0, 0, 4.0 * i};
    estimate.push_back(
        {pose.timestamp_ns, Rigid3d{Eigen::Quaterniond::Identity(), {0, 0, 4.04 * i}}, "one"});
  }
  ASSERT_TRUE(WriteKittiTrajectory(truth, source.directory + "/poses.txt").ok());
  const ServedTrajectory begin(estimate.begin(), estimate.begin() + 20);
  const absl::StatusOr<Accuracy> accuracy = ComputeAccuracy(
      {{"long", source, estimate, {}}, {"short", source, begin, {}}}, 10, Alignment::kSe3);
  ASSERT_TRUE(accuracy.ok()) << accuracy.status();
  ASSERT_TRUE(accuracy->robots[0].relative.has_value());
  EXPECT_NEAR(accuracy->robots[0].relative->translation_percent, 1, 0.05);
  EXPECT_NEAR(accuracy->robots[0].relative->rotation_deg_per_100m, 0, 1e-6);
  ASSERT_EQ(accuracy->robots[0].by_length.size(), 1u);
  EXPECT_EQ(accuracy->robots[0].by_length[0].length_m, 100);
  EXPECT_EQ(accuracy->robots[0].by_length[0].error.translation_percent,
            accuracy->robots[0].relative->translation_percent);
  // A road of 76 m holds no segment of 100 m.
  EXPECT_FALSE(accuracy->robots[1].relative.has_value());
}

TEST(ComputeAccuracyTest, TellsTheMapsSizeFromItsShape) {
  RobotPaths robot = MakeRobot(MakeSequence("large"), 0, 39, {0, 0, 0}, true);
  for (ServedPose& pose : robot.global) pose.frame_from_camera.translation *= 1.25;
  const absl::StatusOr<Accuracy> accuracy = ComputeAccuracy({robot}, 10, Alignment::kSe3);
  ASSERT_TRUE(accuracy.ok()) << accuracy.status();
  ASSERT_TRUE(accuracy->fused.all.has_value());
  EXPECT_GT(accuracy->fused.all->rmse_m, 1);
  ASSERT_TRUE(accuracy->fused.without_scale.has_value());
  EXPECT_NEAR(accuracy->fused.without_scale->rmse_m, 0, 1e-6);
  EXPECT_NEAR(accuracy->fused.without_scale->truth_from_estimate.scale, 0.8, 1e-9);
}

TEST(ComputeAccuracyTest, HasNoFusedErrorForTwoIslands) {
  const SourceSpec source = MakeSequence("islands");
  const absl::StatusOr<Accuracy> accuracy = ComputeAccuracy(
      {MakeRobot(source, 0, 20, {0, 0, 0}, true), MakeRobot(source, 20, 39, {0, 0, 0}, false)}, 10,
      Alignment::kSe3);
  ASSERT_TRUE(accuracy.ok()) << accuracy.status();
  EXPECT_TRUE(accuracy->robots[1].ate_m.has_value());
  EXPECT_FALSE(accuracy->robots[1].ate_global_m.has_value());
  EXPECT_FALSE(accuracy->fused.all.has_value());
  EXPECT_FALSE(accuracy->fused.without_scale.has_value());
  // The picture still gets the part that lies in the global frame.
  EXPECT_TRUE(accuracy->fused.truth_from_global.has_value());
  EXPECT_EQ(accuracy->fused.truth->size(), 21u);
}

TEST(ComputeAccuracyTest, HoldsFoldersThatNameOneFrameAgainstOneTruth) {
  SourceSpec first = MakeSequence("first_of_town");
  SourceSpec second = MakeSequence("second_of_town");
  const auto compute = [&] {
    return ComputeAccuracy(
        {MakeRobot(first, 0, 19, {0, 0, 0}, true), MakeRobot(second, 20, 39, {0.4, 0, 0}, true)}, 0,
        Alignment::kSe3);
  };
  const auto apart = compute();
  ASSERT_TRUE(apart.ok()) << apart.status();
  EXPECT_FALSE(apart->fused.all.has_value());

  first.truth_frame = second.truth_frame = "town";
  const auto together = compute();
  ASSERT_TRUE(together.ok()) << together.status();
  ASSERT_TRUE(together->fused.all.has_value());
  EXPECT_GT(together->fused.all->rmse_m, 0.01);
  EXPECT_LT(together->fused.all->rmse_m, 0.2);
}

TEST(ComputeAccuracyTest, IsEmptyWithoutTruth) {
  const SourceSpec source = MakeSequence("none");
  fs::remove(source.directory + "/poses.txt");
  const absl::StatusOr<Accuracy> accuracy =
      ComputeAccuracy({MakeRobot(source, 0, 39, {0, 0, 0}, true)}, 10, Alignment::kSe3);
  ASSERT_TRUE(accuracy.ok()) << accuracy.status();
  EXPECT_FALSE(accuracy->robots[0].ate_m.has_value());
  EXPECT_FALSE(accuracy->fused.truth.has_value());
}

// Returns what a robot that made no mistake would have mapped of a simulation.
RobotPaths MakePerfectRobot(const std::string& text) {
  const Rigid3d other_from_world{Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5), {1, 2, 3}};
  RobotPaths robot;
  robot.source = *ParseSourceSpec(text);
  const Trajectory truth = (*ReadGroundTruth(robot.source))->trajectory;
  for (const size_t frame : FramesOf(robot.source, truth.size())) {
    const StampedPose& pose = truth[frame];
    robot.local.push_back(
        {pose.timestamp_ns, other_from_world * pose.world_from_camera, "missions/m/localMaps/1"});
  }
  robot.global = robot.local;
  return robot;
}

TEST(ComputeAccuracyTest, HoldsRobotsOfOneSimulatedWorldAgainstOneTruth) {
  const std::string city = "sim:city?seed=3&length=400&";
  const absl::StatusOr<Accuracy> accuracy =
      ComputeAccuracy({MakePerfectRobot(city + "robot=1/2"),
                       MakePerfectRobot(city + "robot=2/2&phase=0.5&noise_seed=4"),
                       MakePerfectRobot(city + "turned=1&start_s=3600")},
                      15, Alignment::kSe3);
  ASSERT_TRUE(accuracy.ok()) << accuracy.status();
  for (const RobotAccuracy& robot : accuracy->robots) {
    EXPECT_THAT(robot.ate_m, Optional(DoubleNear(0, 1e-6)));
  }
  ASSERT_TRUE(accuracy->fused.all.has_value());
  EXPECT_NEAR(accuracy->fused.all->rmse_m, 0, 1e-6);
  ASSERT_TRUE(accuracy->fused.relative.has_value());
  EXPECT_NEAR(accuracy->fused.relative->translation_percent, 0, 1e-6);
}

// The picture of the map shows where both robots really drove, though they took their pictures at
// different moments.
TEST(ComputeAccuracyTest, KeepsTheTruthOfAllThatWentOneWay) {
  const std::string city = "sim:city?seed=3&length=200&";
  const absl::StatusOr<Accuracy> accuracy =
      ComputeAccuracy({MakePerfectRobot(city + "robot=1/2"),
                       MakePerfectRobot(city + "robot=2/2&phase=0.5&noise_seed=4")},
                      15, Alignment::kSe3);
  ASSERT_TRUE(accuracy.ok()) << accuracy.status();
  ASSERT_TRUE(accuracy->fused.truth.has_value());
  const RobotPaths whole = MakePerfectRobot(city + "phase=0");
  // Half a frame later one picture less may fit.
  EXPECT_GE(accuracy->fused.truth->size() + 1, whole.local.size());
}

TEST(WayOfTest, IsThatOfTheWorldTheWayAndTheClock) {
  const auto way = [](const std::string& options) {
    return WayOf(*ParseSourceSpec("sim:city?seed=3&length=200" + options));
  };
  EXPECT_EQ(way("&robot=1/2"), way("&phase=0.5&noise_seed=4&frames=3:20"));
  for (const char* other : {"&turned=1", "&start_s=5", "&kidnap=3:6", "&world=4"}) {
    EXPECT_NE(way(""), way(other)) << other;
  }
  // Turned, another phase is another place at one time.
  EXPECT_NE(way("&turned=1"), way("&turned=1&phase=0.5"));
}

TEST(ComputeAccuracyTest, HasNoFusedErrorForTwoSimulatedWorlds) {
  const absl::StatusOr<Accuracy> accuracy =
      ComputeAccuracy({MakePerfectRobot("sim:city?seed=3&length=200"),
                       MakePerfectRobot("sim:city?seed=4&length=200")},
                      15, Alignment::kSe3);
  ASSERT_TRUE(accuracy.ok()) << accuracy.status();
  EXPECT_THAT(accuracy->robots[1].ate_m, Optional(DoubleNear(0, 1e-6)));
  EXPECT_FALSE(accuracy->fused.all.has_value());
}

}  // namespace
}  // namespace corbslam::services
