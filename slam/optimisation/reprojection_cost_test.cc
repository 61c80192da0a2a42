#include "slam/optimisation/reprojection_cost.h"

#include <ceres/gradient_checker.h>
#include <gtest/gtest.h>

#include <vector>

#include "slam/geometry/lie.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam {
namespace {

const Vector6d kTangent = (Vector6d() << 0.4, -0.3, 1.1, 0.3, -0.5, 0.2).finished();
constexpr double kTolerance = 1e-6;

PoseBlock BlockOf(const Rigid3d& pose) { return ToPoseBlock(pose.rotation, pose.translation); }

template <int kResiduals>
void CheckJacobians(const Rigid3d& camera_from_map, const Eigen::Vector3d& x_in_camera) {
  const Camera camera = testing::SyntheticCamera();
  const ReprojectionCost<kResiduals> cost(camera, MakeMeasurement({310, 190}, 9, 1.7));
  const PoseBlock pose = BlockOf(camera_from_map);
  const Eigen::Vector3d point = camera_from_map.Inverse() * x_in_camera;
  const PoseManifold pose_manifold;
  const std::vector<const ceres::Manifold*> manifolds = {&pose_manifold, nullptr};
  const ceres::NumericDiffOptions numeric;
  const ceres::GradientChecker checker(&cost, &manifolds, numeric);
  const double* parameters[2] = {pose.data(), point.data()};
  ceres::GradientChecker::ProbeResults results;
  EXPECT_TRUE(checker.Probe(parameters, kTolerance, &results)) << results.error_log;
}

TEST(ReprojectionCostTest, JacobiansAgreeWithNumericDifferences) {
  const Rigid3d pose = ExpSE3(kTangent);
  for (const Rigid3d& camera_from_map : {pose, pose.Inverse(), Rigid3d::Identity()}) {
    for (const Eigen::Vector3d& x : {Eigen::Vector3d(0.5, -0.4, 3), Eigen::Vector3d(-7, 4, 60)}) {
      CheckJacobians<2>(camera_from_map, x);
      CheckJacobians<3>(camera_from_map, x);
    }
  }
}

// On the manifold the Jacobians are those that the other solver uses.
TEST(ReprojectionCostTest, JacobianOfAMotionIsThatOfTheSharedMaths) {
  const Camera camera = testing::SyntheticCamera();
  const PixelMeasurement measured = MakeMeasurement({310, 190}, 9, 4);
  const StereoReprojectionCost cost(camera, measured);
  const Rigid3d camera_from_map = ExpSE3(kTangent);
  const PoseBlock pose = BlockOf(camera_from_map);
  const Eigen::Vector3d x(0.5, -0.4, 3);
  const Eigen::Vector3d point = camera_from_map.Inverse() * x;
  const double* parameters[2] = {pose.data(), point.data()};
  Eigen::Vector3d residual;
  Eigen::Matrix<double, 3, 7, Eigen::RowMajor> J;
  double* jacobians[2] = {J.data(), nullptr};
  ASSERT_TRUE(cost.Evaluate(parameters, residual.data(), jacobians));
  Eigen::Matrix<double, 7, 6, Eigen::RowMajor> J_plus;
  PoseManifold().PlusJacobian(pose.data(), J_plus.data());
  const auto expected = PoseJacobian(ReprojectionJacobian(camera, x, true), x);
  EXPECT_LT((2 * J * J_plus - expected).norm(), 1e-9);
  EXPECT_LT((2 * residual - ReprojectionResidual(camera, x, measured)).norm(), 1e-9);
}

TEST(ReprojectionCostTest, APointBehindTheCameraCostsAConstant) {
  const Camera camera = testing::SyntheticCamera();
  const MonoReprojectionCost cost(camera, MakeMeasurement({310, 190}, 0, 1));
  const PoseBlock pose = BlockOf(Rigid3d::Identity());
  const Eigen::Vector3d point(0.1, 0.2, -3);
  const double* parameters[2] = {pose.data(), point.data()};
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, 7, Eigen::RowMajor> J_pose;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_point;
  double* jacobians[2] = {J_pose.data(), J_point.data()};
  ASSERT_TRUE(cost.Evaluate(parameters, residual.data(), jacobians));
  EXPECT_NEAR(residual.squaredNorm(), kUnseenFactor * kChi2Mono, 1e-9);
  EXPECT_TRUE(J_pose.isZero() && J_point.isZero());
}

TEST(PoseManifoldTest, PlusPerturbsOnTheLeftAndMinusUndoesIt) {
  const PoseManifold manifold;
  const PoseBlock pose = BlockOf(ExpSE3(kTangent));
  const Vector6d step = (Vector6d() << 0.3, -0.2, 0.5, 0.1, 0.7, -0.4).finished();
  PoseBlock moved{};
  manifold.Plus(pose.data(), step.data(), moved.data());
  const Rigid3d expected = Rigid3d{ExpSO3(step.tail<3>()), step.head<3>()} * ExpSE3(kTangent);
  const PoseBlock expected_block = BlockOf(expected);
  for (size_t i = 0; i < moved.size(); ++i) EXPECT_NEAR(moved[i], expected_block[i], 1e-12) << i;
  Vector6d back;
  manifold.Minus(moved.data(), pose.data(), back.data());
  EXPECT_LT((back - step).norm(), 1e-12);
}

TEST(PoseManifoldTest, JacobiansAgreeWithNumericDifferencesAndInvertEachOther) {
  const PoseManifold manifold;
  const PoseBlock pose = BlockOf(ExpSE3(kTangent));
  Eigen::Matrix<double, 7, 6, Eigen::RowMajor> J_plus;
  Eigen::Matrix<double, 6, 7, Eigen::RowMajor> J_minus;
  manifold.PlusJacobian(pose.data(), J_plus.data());
  manifold.MinusJacobian(pose.data(), J_minus.data());
  EXPECT_LT((J_minus * J_plus - Matrix6d::Identity()).norm(), 1e-12);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 6; ++i) {
    PoseBlock sides[2];
    for (const int side : {0, 1}) {
      const Vector6d step = (side == 0 ? kStep : -kStep) * Vector6d::Unit(i);
      manifold.Plus(pose.data(), step.data(), sides[side].data());
    }
    using Vector7 = Eigen::Map<const Eigen::Matrix<double, 7, 1>>;
    const Eigen::Matrix<double, 7, 1> numeric =
        (Vector7(sides[0].data()) - Vector7(sides[1].data())) / (2 * kStep);
    EXPECT_LT((numeric - J_plus.col(i)).norm(), 1e-8) << i;
  }
}

}  // namespace
}  // namespace corbslam
