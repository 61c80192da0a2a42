#include "services/simulation/motion/pose_sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "slam/evaluation/trajectory_io.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;

// A camera that goes round a circle of 20 m, looking ahead, 10 Hz at 10 m/s.
Rigid3d OnCircle(double time_s) {
  const double angle = 0.5 * time_s;
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY())),
          {20 - 20 * std::cos(angle), 0.1 * std::sin(time_s), 20 * std::sin(angle)}};
}

PoseSequence Circle() {
  std::vector<Rigid3d> poses;
  for (int i = 0; i <= 50; ++i) poses.push_back(OnCircle(0.1 * i));
  return *PoseSequence::Make(poses, 100'000'000);
}

TEST(PoseSequenceTest, HasThePosesThatItIsMadeOf) {
  const PoseSequence sequence = Circle();
  EXPECT_EQ(sequence.duration_ns(), 5'000'000'000);
  for (int i = 0; i <= 50; ++i) {
    const Rigid3d pose = sequence.PoseAt(i * int64_t{100'000'000});
    EXPECT_EQ(pose.translation, OnCircle(0.1 * i).translation);
    EXPECT_EQ(pose.rotation.coeffs(), OnCircle(0.1 * i).rotation.coeffs());
  }
}

TEST(PoseSequenceTest, FollowsTheCurveInBetween) {
  const PoseSequence sequence = Circle();
  for (int i = 10; i < 490; ++i) {
    const Rigid3d pose = sequence.PoseAt(i * int64_t{10'000'000});
    const Rigid3d truth = OnCircle(0.01 * i);
    // A straight line between the poses would be 6 mm off.
    EXPECT_LT((pose.translation - truth.translation).norm(), 1e-3) << i;
    EXPECT_LT(RotationAngle(pose.rotation.conjugate() * truth.rotation), 1e-4) << i;
  }
}

TEST(PoseSequenceTest, TakesUnevenTimes) {
  Trajectory trajectory;
  for (const double time_s : {0.0, 0.1, 0.13, 0.3, 0.35, 0.5}) {
    trajectory.push_back({5'000'000'000 + std::llround(time_s * 1e9), OnCircle(time_s)});
  }
  const absl::StatusOr<PoseSequence> sequence = PoseSequence::Make(trajectory);
  ASSERT_TRUE(sequence.ok()) << sequence.status();
  EXPECT_EQ(sequence->duration_ns(), 500'000'000);
  EXPECT_LT((sequence->PoseAt(200'000'000).translation - OnCircle(0.2).translation).norm(), 3e-3);
}

TEST(PoseSequenceTest, StandsStillBeyondItsEnds) {
  const PoseSequence sequence = Circle();
  EXPECT_EQ(sequence.PoseAt(-1).translation, OnCircle(0).translation);
  EXPECT_EQ(sequence.PoseAt(6'000'000'000).translation, OnCircle(5).translation);
}

TEST(PoseSequenceTest, RefusesWhatIsNoPath) {
  EXPECT_THAT(std::string(PoseSequence::Make({{0, {}}}).status().message()), HasSubstr("1 poses"));
  EXPECT_THAT(std::string(PoseSequence::Make({{0, {}}, {10, {}}, {10, {}}}).status().message()),
              HasSubstr("pose 2"));
}

TEST(TurnedBackTest, LooksWhereItCameFromAndStaysUpright) {
  const Rigid3d pose = OnCircle(1.0);
  const Rigid3d back = TurnedBack(pose);
  EXPECT_EQ(back.translation, pose.translation);
  const Eigen::Vector3d ahead = pose.rotation * Eigen::Vector3d::UnitZ();
  EXPECT_LT((back.rotation * Eigen::Vector3d::UnitZ() + ahead).norm(), 1e-9);
  const Eigen::Vector3d down = pose.rotation * Eigen::Vector3d::UnitY();
  EXPECT_LT((back.rotation * Eigen::Vector3d::UnitY() - down).norm(), 1e-9);
}

TEST(ReadPoseSequenceTest, ReadsBothForms) {
  const std::string folder = ::testing::TempDir();
  const Trajectory truth = Circle().trajectory();
  ASSERT_TRUE(WriteKittiTrajectory(truth, folder + "/poses.kitti").ok());
  ASSERT_TRUE(WriteTumTrajectory(truth, folder + "/poses.tum").ok());
  for (const char* name : {"/poses.kitti", "/poses.tum"}) {
    const absl::StatusOr<PoseSequence> sequence = ReadPoseSequence(folder + name);
    ASSERT_TRUE(sequence.ok()) << sequence.status();
    EXPECT_EQ(sequence->duration_ns(), 5'000'000'000) << name;
    EXPECT_LT((sequence->PoseAt(3'000'000'000).translation - OnCircle(3).translation).norm(), 1e-6)
        << name;
  }
}

TEST(ReadPoseSequenceTest, NamesTheFile) {
  EXPECT_EQ(ReadPoseSequence("/nowhere.txt").status().code(), absl::StatusCode::kNotFound);
  const std::string path = ::testing::TempDir() + "/bad_poses.txt";
  std::ofstream(path) << "1 0 0 0 0 1 0 0 0 0 1 0\n1 2 3\n";
  const absl::Status status = ReadPoseSequence(path).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("bad_poses.txt:2"));
}

}  // namespace
}  // namespace corbslam
