#include "slam/optimisation/pose_optimisation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <vector>

#include "slam/geometry/lie.h"
#include "slam/optimisation/reprojection.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam {
namespace {

using testing::MakeSyntheticScene;
using testing::SyntheticScene;
using testing::SyntheticSceneOptions;

std::vector<PoseObservation> ObservationsOf(const SyntheticScene& scene, const Keyframe& keyframe) {
  std::vector<PoseObservation> observations;
  for (size_t i = 0; i < keyframe.points.size(); ++i) {
    const Keypoint& keypoint = keyframe.keypoints()[i];
    observations.push_back({scene.true_position_in_map.at(keyframe.points[i]), keypoint.Pixel(),
                            keypoint.disparity_px, ScalePyramid::Variance_px2(keypoint.octave)});
  }
  return observations;
}

const Keyframe& Third(const SyntheticScene& scene) {
  return std::next(scene.map.keyframes().begin(), 3)->second;
}

double CentreError(const Rigid3d& a, const Rigid3d& b) {
  return (CameraCentre(a) - CameraCentre(b)).norm();
}

const Rigid3d kOffset = ExpSE3((Vector6d() << 0.2, -0.1, 0.15, 0.02, 0.03, -0.02).finished());

TEST(ReprojectionTest, JacobiansAgreeWithNumericDifferences) {
  const Camera camera = testing::SyntheticCamera();
  const Eigen::Vector3d x(0.7, -0.4, 3.1);
  constexpr double kStep = 1e-6;
  for (const double disparity_px : {0.0, 12.0}) {
    const PixelMeasurement measured = MakeMeasurement({300, 200}, disparity_px, 1);
    const Eigen::Matrix3d J_x = ReprojectionJacobian(camera, x, measured.has_depth);
    const auto J_pose = PoseJacobian(J_x, x);
    for (int i = 0; i < 6; ++i) {
      const Vector6d step = kStep * Vector6d::Unit(i);
      const Eigen::Vector3d numeric = (ReprojectionResidual(camera, ExpSE3(step) * x, measured) -
                                       ReprojectionResidual(camera, ExpSE3(-step) * x, measured)) /
                                      (2 * kStep);
      EXPECT_LT((J_pose.col(i) - numeric).norm(), 1e-5) << i;
      if (i >= 3) continue;
      EXPECT_LT((J_x.col(i) - numeric).norm(), 1e-5) << i;
    }
  }
}

TEST(ReprojectionTest, HubersWeightIsTheDerivativeOfItsCost) {
  for (const double chi2 : {0.5, 5.9, 6.1, 400.0}) {
    const double numeric =
        (HuberCost(chi2 + 1e-5, 5.991).cost - HuberCost(chi2 - 1e-5, 5.991).cost) / 2e-5;
    EXPECT_NEAR(HuberCost(chi2, 5.991).weight, numeric, 1e-6) << chi2;
  }
}

TEST(ReprojectionTest, CostsGrowUpToWhatIsNotSeenAndNoFurther) {
  constexpr double kUnseen = kUnseenFactor * kChi2Mono;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const bool robust : {false, true}) {
    const RobustCost below = ObservationLoss(0.999 * kUnseen, kChi2Mono, robust);
    const RobustCost unseen = ObservationLoss(kInfinity, kChi2Mono, robust);
    EXPECT_EQ(below.weight, robust ? HuberCost(0.999 * kUnseen, kChi2Mono).weight : 1);
    EXPECT_LT(below.cost, unseen.cost);
    EXPECT_NEAR(below.cost, unseen.cost, 0.002 * unseen.cost);
    for (const double chi2 : {kUnseen, 1e12, kInfinity}) {
      EXPECT_EQ(ObservationLoss(chi2, kChi2Mono, robust).cost, unseen.cost);
      EXPECT_EQ(ObservationLoss(chi2, kChi2Mono, robust).weight, 0);
    }
  }
}

TEST(OptimisePoseTest, FindsTheExactPoseFromExactPixels) {
  const SyntheticScene scene = MakeSyntheticScene({});
  const Keyframe& keyframe = Third(scene);
  for (const Rigid3d& offset : {kOffset, kOffset.Inverse()}) {
    const auto observations = ObservationsOf(scene, keyframe);
    const PoseEstimate estimate =
        OptimisePose(scene.camera, offset * keyframe.camera_from_map, observations);
    EXPECT_LT(CentreError(estimate.camera_from_map, keyframe.camera_from_map), 1e-5);
    EXPECT_EQ(estimate.inliers, static_cast<int>(observations.size()));
  }
}

TEST(OptimisePoseTest, MonocularObservationsAreEnough) {
  SyntheticSceneOptions options;
  options.share_with_depth = 0;
  const SyntheticScene scene = MakeSyntheticScene(options);
  const Keyframe& keyframe = Third(scene);
  const PoseEstimate estimate = OptimisePose(scene.camera, kOffset * keyframe.camera_from_map,
                                             ObservationsOf(scene, keyframe));
  EXPECT_LT(CentreError(estimate.camera_from_map, keyframe.camera_from_map), 1e-5);
}

TEST(OptimisePoseTest, TellsOutliersFromInliers) {
  SyntheticSceneOptions options;
  options.pixel_noise_px = 0.7;
  options.share_of_outliers = 0.3;
  const SyntheticScene scene = MakeSyntheticScene(options);
  const Keyframe& keyframe = Third(scene);
  const PoseEstimate estimate = OptimisePose(scene.camera, kOffset * keyframe.camera_from_map,
                                             ObservationsOf(scene, keyframe));
  EXPECT_LT(CentreError(estimate.camera_from_map, keyframe.camera_from_map), 0.02);
  int wrong = 0;
  for (size_t i = 0; i < keyframe.points.size(); ++i) {
    const bool is_outlier = std::binary_search(scene.outliers.begin(), scene.outliers.end(),
                                               std::pair(keyframe.points[i], keyframe.id()));
    if (is_outlier == (estimate.is_inlier[i] != 0)) ++wrong;
  }
  EXPECT_LE(wrong, static_cast<int>(keyframe.points.size()) / 20);
}

TEST(OptimisePoseTest, TooFewObservationsReturnTheInitialPose) {
  const SyntheticScene scene = MakeSyntheticScene({});
  const Keyframe& keyframe = Third(scene);
  auto observations = ObservationsOf(scene, keyframe);
  for (const size_t count : {size_t{0}, size_t{2}}) {
    observations.resize(count);
    const PoseEstimate estimate = OptimisePose(scene.camera, kOffset, observations);
    EXPECT_EQ(CentreError(estimate.camera_from_map, kOffset), 0);
    EXPECT_EQ(estimate.is_inlier.size(), count);
  }
}

TEST(OptimisePoseTest, PointsBehindTheCameraAreOutliers) {
  const SyntheticScene scene = MakeSyntheticScene({});
  const Keyframe& keyframe = Third(scene);
  auto observations = ObservationsOf(scene, keyframe);
  observations[5].x_in_map = keyframe.camera_from_map.Inverse() * Eigen::Vector3d(0, 0, -5);
  const PoseEstimate estimate = OptimisePose(scene.camera, keyframe.camera_from_map, observations);
  EXPECT_FALSE(estimate.is_inlier[5]);
  EXPECT_EQ(estimate.inliers, static_cast<int>(observations.size()) - 1);
}

TEST(OptimisePoseTest, ValuesThatAreNotFiniteDoNoHarm) {
  const SyntheticScene scene = MakeSyntheticScene({});
  const Keyframe& keyframe = Third(scene);
  auto observations = ObservationsOf(scene, keyframe);
  observations[2].pixel.x() = std::numeric_limits<double>::quiet_NaN();
  const PoseEstimate estimate = OptimisePose(scene.camera, keyframe.camera_from_map, observations);
  EXPECT_TRUE(estimate.camera_from_map.translation.allFinite());
}

}  // namespace
}  // namespace corbslam
