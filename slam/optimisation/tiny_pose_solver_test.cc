#include "slam/optimisation/testing/tiny_pose_solver.h"

#include <gtest/gtest.h>

#include <iterator>

#include "slam/geometry/lie.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam::testing {
namespace {

TEST(TinyPoseCostTest, JacobianAgreesWithNumericDifferences) {
  TinyPoseCost cost{SyntheticCamera(), {}, true};
  // The measurements lie within the bound, beyond it, and far off; with and without depth.
  for (const double x_px : {430.0, 436.0, 500.0}) {
    cost.measurements.push_back({{0.5, -0.4, 3.5}, MakeMeasurement({x_px, 200}, 14, 1.3)});
    cost.measurements.push_back({{0.5, -0.4, 3.5}, MakeMeasurement({x_px, 200}, 0, 1.3)});
  }
  const Vector6d at = (Vector6d() << 0.05, -0.02, 0.03, 0.02, 0.04, -0.3).finished();
  const int rows = cost.NumResiduals();
  Eigen::VectorXd residuals(rows);
  Eigen::MatrixXd J(rows, 6);
  ASSERT_TRUE(cost(at.data(), residuals.data(), J.data()));
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 6; ++i) {
    const Vector6d above = at + kStep * Vector6d::Unit(i);
    const Vector6d below = at - kStep * Vector6d::Unit(i);
    Eigen::VectorXd r_above(rows);
    Eigen::VectorXd r_below(rows);
    cost(above.data(), r_above.data(), nullptr);
    cost(below.data(), r_below.data(), nullptr);
    const Eigen::VectorXd numeric = (r_above - r_below) / (2 * kStep);
    EXPECT_LT((numeric - J.col(i)).norm(), 1e-6 * (1 + numeric.norm())) << i;
  }
}

TEST(OptimisePoseTinyTest, AgreesWithOurOwnSolver) {
  SyntheticSceneOptions options;
  options.share_with_depth = 0.7;
  options.pixel_noise_px = 0.7;
  options.share_of_outliers = 0.1;
  const SyntheticScene scene = MakeSyntheticScene(options);
  const Keyframe& keyframe = std::next(scene.map.keyframes().begin(), 3)->second;
  std::vector<PoseObservation> observations;
  for (size_t i = 0; i < keyframe.points.size(); ++i) {
    const Keypoint& keypoint = keyframe.keypoints()[i];
    observations.push_back({scene.true_position_in_map.at(keyframe.points[i]), keypoint.Pixel(),
                            keypoint.disparity_px, ScalePyramid::Variance_px2(keypoint.octave)});
  }
  const Rigid3d initial = ExpSE3((Vector6d() << 0.1, -0.1, 0.1, 0.02, 0.01, -0.02).finished()) *
                          keyframe.camera_from_map;
  const PoseEstimate own = OptimisePose(scene.camera, initial, observations);
  const PoseEstimate tiny = OptimisePoseTiny(scene.camera, initial, observations);
  EXPECT_GT(own.inliers, 100);
  EXPECT_EQ(own.is_inlier, tiny.is_inlier);
  EXPECT_LT(LogSE3(own.camera_from_map * tiny.camera_from_map.Inverse()).norm(), 1e-5);
}

}  // namespace
}  // namespace corbslam::testing
