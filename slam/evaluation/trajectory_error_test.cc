#include "slam/evaluation/trajectory_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace corbslam {
namespace {

using ::testing::DoubleNear;

// A climbing spiral of `count` poses.
Trajectory MakeSpiral(int count) {
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    const double angle = 0.05 * i;
    StampedPose pose;
    pose.timestamp_ns = i;
    pose.world_from_camera.translation = {10 * std::cos(angle), 10 * std::sin(angle), 0.1 * i};
    pose.world_from_camera.rotation = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ());
    trajectory.push_back(pose);
  }
  return trajectory;
}

std::vector<PosePair> PairUp(const Trajectory& truth, const Similarity3d& estimate_from_truth) {
  std::vector<PosePair> pairs;
  for (const StampedPose& pose : truth) {
    PosePair pair{pose, pose};
    pair.estimate.world_from_camera.translation =
        estimate_from_truth * pose.world_from_camera.translation;
    pair.estimate.world_from_camera.rotation =
        estimate_from_truth.rotation * pose.world_from_camera.rotation;
    pairs.push_back(pair);
  }
  return pairs;
}

const Similarity3d kMoved{1.0, Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5), {3, -2, 7}};

TEST(AbsoluteErrorTest, IsZeroForAMovedCopy) {
  const absl::StatusOr<AbsoluteError> error =
      ComputeAbsoluteError(PairUp(MakeSpiral(50), kMoved), Alignment::kSe3);
  ASSERT_TRUE(error.ok()) << error.status();
  EXPECT_THAT(error->rmse_m, DoubleNear(0, 1e-9));
  const Similarity3d identity = error->truth_from_estimate * kMoved;
  EXPECT_LT(identity.translation.norm(), 1e-9);
}

TEST(AbsoluteErrorTest, OnlySim3TakesOutScale) {
  Similarity3d scaled = kMoved;
  scaled.scale = 2;
  const std::vector<PosePair> pairs = PairUp(MakeSpiral(50), scaled);
  EXPECT_GT(ComputeAbsoluteError(pairs, Alignment::kSe3)->rmse_m, 1.0);
  const absl::StatusOr<AbsoluteError> error = ComputeAbsoluteError(pairs, Alignment::kSim3);
  EXPECT_THAT(error->rmse_m, DoubleNear(0, 1e-9));
  EXPECT_THAT(error->truth_from_estimate.scale, DoubleNear(0.5, 1e-9));
}

// Four corners of a square of side 2, each pushed 0.5 outwards in turn in +z and -z: the best
// alignment is the identity (by symmetry), so every distance is 0.5.
TEST(AbsoluteErrorTest, HasAKnownValue) {
  std::vector<PosePair> pairs(4);
  const double corners[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
  for (size_t i = 0; i < 4; ++i) {
    pairs[i].truth.world_from_camera.translation = {corners[i][0], corners[i][1], 0};
    pairs[i].estimate.world_from_camera.translation = {corners[i][0], corners[i][1],
                                                       i % 2 == 0 ? 0.5 : -0.5};
  }
  const absl::StatusOr<AbsoluteError> error = ComputeAbsoluteError(pairs, Alignment::kSe3);
  EXPECT_THAT(error->rmse_m, DoubleNear(0.5, 1e-9));
  EXPECT_THAT(error->median_m, DoubleNear(0.5, 1e-9));
  EXPECT_THAT(error->max_m, DoubleNear(0.5, 1e-9));
  EXPECT_EQ(error->poses, 4u);
}

// Two robots, each perfect in itself, in frames 4 m apart: one alignment can't mend both.
TEST(AbsoluteErrorTest, TheMedianOfAnEvenNumberIsTheMeanOfTheMiddleTwo) {
  // Twice the square above: it stays where it is, so that the distances are 0.5 and 1.5.
  std::vector<PosePair> pairs(8);
  const double corners[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
  for (size_t i = 0; i < 8; ++i) {
    const double size = i < 4 ? 1 : 3;
    const double height = i < 4 ? 0.5 : 1.5;
    pairs[i].truth.world_from_camera.translation = {size * corners[i % 4][0],
                                                    size * corners[i % 4][1], 0};
    pairs[i].estimate.world_from_camera.translation = {
        size * corners[i % 4][0], size * corners[i % 4][1], i % 2 == 0 ? height : -height};
  }
  EXPECT_THAT(ComputeAbsoluteError(pairs, Alignment::kSe3)->median_m, DoubleNear(1, 1e-9));
}

TEST(AbsoluteErrorTest, OneAlignmentShowsTwoMapsThatDoNotFit) {
  std::vector<PosePair> pairs = PairUp(MakeSpiral(50), Similarity3d::Identity());
  Similarity3d shifted = Similarity3d::Identity();
  shifted.translation.z() = 4;
  const std::vector<PosePair> other = PairUp(MakeSpiral(50), shifted);
  EXPECT_LT(ComputeAbsoluteError(other, Alignment::kSe3)->rmse_m, 1e-9);
  pairs.insert(pairs.end(), other.begin(), other.end());
  EXPECT_THAT(ComputeAbsoluteError(pairs, Alignment::kSe3)->rmse_m, DoubleNear(2, 1e-6));
}

TEST(AbsoluteErrorTest, NeedsThreePoses) {
  EXPECT_EQ(ComputeAbsoluteError(PairUp(MakeSpiral(2), kMoved), Alignment::kSe3).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST(AbsoluteErrorTest, HasNoScaleWithoutMotion) {
  std::vector<PosePair> pairs = PairUp(MakeSpiral(5), kMoved);
  for (PosePair& pair : pairs) pair.estimate.world_from_camera.translation.setZero();
  EXPECT_EQ(ComputeAbsoluteError(pairs, Alignment::kSim3).status().code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_TRUE(ComputeAbsoluteError(pairs, Alignment::kSe3).ok());
}

// 251 m straight ahead, a pose a metre; the estimate is 2 % too long and turns 0.01 degrees/m.
TEST(RelativeErrorTest, HasKnownValues) {
  std::vector<PosePair> pairs;
  for (int i = 0; i <= 250; ++i) {
    PosePair pair;
    pair.truth.world_from_camera.translation.z() = i;
    pair.estimate.world_from_camera.translation.z() = 1.02 * i;
    pairs.push_back(pair);
  }
  const std::optional<RelativeError> straight = ComputeRelativeError(pairs, {});
  ASSERT_TRUE(straight.has_value());
  // Segments end at the first pose beyond their length, after 101 and 201 m.
  EXPECT_EQ(straight->segments, 15 + 5);
  EXPECT_NEAR(straight->translation_percent, 0.75 * 2.02 + 0.25 * 2.01, 1e-9);
  EXPECT_NEAR(straight->rotation_deg_per_100m, 0, 1e-9);

  for (size_t i = 0; i < pairs.size(); ++i) {
    const double angle = 0.01 * static_cast<double>(i) * std::numbers::pi / 180;
    pairs[i].estimate.world_from_camera.rotation =
        Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY());
  }
  EXPECT_NEAR(ComputeRelativeError(pairs, {})->rotation_deg_per_100m, 0.75 * 1.01 + 0.25 * 1.005,
              1e-6);
}

TEST(ErrorByLengthTest, AddsUpToTheRelativeError) {
  const Trajectory truth = MakeSpiral(1200);
  std::vector<PosePair> pairs = PairUp(truth, kMoved);
  for (size_t i = 0; i < pairs.size(); ++i) {
    pairs[i].estimate.world_from_camera.translation.z() += 1e-5 * static_cast<double>(i * i);
  }
  const std::vector<LengthError> errors = ComputeErrorByLength(pairs, truth);
  ASSERT_EQ(errors.size(), 6u) << "1,199 steps of half a metre";
  double sum = 0;
  int segments = 0;
  for (size_t i = 0; i < errors.size(); ++i) {
    EXPECT_EQ(errors[i].length_m, 100.0 * static_cast<double>(i + 1));
    sum += errors[i].error.segments * errors[i].error.translation_percent;
    segments += errors[i].error.segments;
  }
  const std::optional<RelativeError> all = ComputeRelativeError(pairs, truth);
  EXPECT_EQ(segments, all->segments);
  EXPECT_NEAR(sum / segments, all->translation_percent, 1e-9);
  EXPECT_TRUE(ComputeErrorByLength({}, truth).empty());
}

TEST(RelativeErrorTest, OfSeveralPathsItIsTheMeanOverTheirSegments) {
  const auto mean = MeanOverSegments({{1, 0.5, 10}, {4, 2, 20}});
  ASSERT_TRUE(mean.has_value());
  EXPECT_NEAR(mean->translation_percent, 3, 1e-12);
  EXPECT_NEAR(mean->rotation_deg_per_100m, 1.5, 1e-12);
  EXPECT_EQ(mean->segments, 30);
  EXPECT_FALSE(MeanOverSegments({}).has_value());
}

TEST(RelativeErrorTest, IsAbsentForAShortPath) {
  EXPECT_FALSE(ComputeRelativeError(PairUp(MakeSpiral(50), kMoved), MakeSpiral(50)).has_value());
}

}  // namespace
}  // namespace corbslam
