#include "slam/geometry/lie.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace corbslam {
namespace {

// Returns angles from vanishing to large, with and without scale.
std::vector<Vector7d> Tangents() {
  std::vector<Vector7d> tangents;
  const Eigen::Vector3d axis = Eigen::Vector3d(0.3, -0.8, 0.5).normalized();
  for (const double angle : {0.0, 1e-9, 1e-5, 1e-3, 0.0999, 0.1001, 1.0, 3.0}) {
    for (const double log_scale : {0.0, 1e-7, -0.2, 0.9}) {
      Vector7d tangent;
      tangent << 1.5, -2, 0.7, angle * axis, log_scale;
      tangents.push_back(tangent);
    }
  }
  return tangents;
}

double Difference(const Similarity3d& a, const Similarity3d& b) {
  return std::abs(a.scale - b.scale) + (a.translation - b.translation).norm() +
         a.rotation.angularDistance(b.rotation);
}

TEST(LieTest, LogInvertsExp) {
  for (const Vector7d& tangent : Tangents()) {
    EXPECT_LT((LogSim3(ExpSim3(tangent)) - tangent).norm(), 1e-10) << tangent.transpose();
    const Vector6d rigid = tangent.head<6>();
    EXPECT_LT((LogSE3(ExpSE3(rigid)) - rigid).norm(), 1e-10) << tangent.transpose();
  }
}

TEST(LieTest, ExpOfTheNegativeIsTheInverse) {
  for (const Vector7d& tangent : Tangents()) {
    EXPECT_LT(Difference(ExpSim3(-tangent), ExpSim3(tangent).Inverse()), 1e-10);
  }
}

TEST(LieTest, Sim3WithoutScaleIsSE3) {
  for (Vector7d tangent : Tangents()) {
    tangent[6] = 0;
    const Rigid3d rigid = ExpSE3(tangent.head<6>());
    EXPECT_LT(Difference(ExpSim3(tangent), Similarity3d::FromRigid(rigid)), 1e-11);
  }
}

TEST(LieTest, LogTakesTheShortWayForBothSignsOfAQuaternion) {
  Eigen::Quaterniond rotation = ExpSO3({0.1, 0.2, -0.3});
  rotation.coeffs() *= -1;
  EXPECT_LT((LogSO3(rotation) - Eigen::Vector3d(0.1, 0.2, -0.3)).norm(), 1e-12);
}

TEST(LieTest, AdjointCarriesTangentsAcross) {
  const Similarity3d T = ExpSim3((Vector7d() << 1, 2, 3, 0.4, -0.5, 0.6, 0.3).finished());
  const Rigid3d M = {T.rotation, T.translation};
  for (const Vector7d& tangent : Tangents()) {
    const Vector7d carried = AdjointSim3(T) * tangent;
    EXPECT_LT(Difference(T * ExpSim3(tangent) * T.Inverse(), ExpSim3(carried)), 1e-9);
    const Vector6d moved = AdjointSE3(M) * tangent.head<6>();
    EXPECT_LT(Difference(Similarity3d::FromRigid(M * ExpSE3(tangent.head<6>()) * M.Inverse()),
                         Similarity3d::FromRigid(ExpSE3(moved))),
              1e-9);
  }
}

TEST(LieTest, InverseLeftJacobiansAgreeWithNumericDifferences) {
  constexpr double kStep = 1e-6;
  for (const Vector7d& tangent : Tangents()) {
    const Matrix7d J = InverseLeftJacobianSim3(tangent);
    const Matrix6d J_rigid = InverseLeftJacobianSE3(tangent.head<6>());
    for (int i = 0; i < 7; ++i) {
      const Vector7d step = kStep * Vector7d::Unit(i);
      const Vector7d numeric =
          (LogSim3(ExpSim3(step) * ExpSim3(tangent)) - LogSim3(ExpSim3(-step) * ExpSim3(tangent))) /
          (2 * kStep);
      EXPECT_LT((J.col(i) - numeric).norm(), 1e-7) << i << ": " << tangent.transpose();
      if (i == 6) continue;
      const Vector6d rigid_step = step.head<6>();
      const Vector6d rigid_numeric = (LogSE3(ExpSE3(rigid_step) * ExpSE3(tangent.head<6>())) -
                                      LogSE3(ExpSE3(-rigid_step) * ExpSE3(tangent.head<6>()))) /
                                     (2 * kStep);
      EXPECT_LT((J_rigid.col(i) - rigid_numeric).norm(), 1e-7) << i << ": " << tangent.transpose();
    }
  }
}

}  // namespace
}  // namespace corbslam
