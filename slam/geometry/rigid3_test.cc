#include "slam/geometry/rigid3.h"

#include <cmath>

#include "gtest/gtest.h"

namespace corbslam {
namespace {

const Rigid3d kMotion = {
    Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())),
    Eigen::Vector3d(4, -5, 6)};
const Eigen::Vector3d kPoint(0.3, -2, 9);

TEST(Rigid3Test, InverseUndoesTheMotion) {
  EXPECT_LT((kMotion.Inverse() * (kMotion * kPoint) - kPoint).norm(), 1e-12);
}

TEST(Rigid3Test, ProductAppliesTheRightFactorFirst) {
  const Rigid3d other = {Eigen::Quaterniond(Eigen::AngleAxisd(-1.1, Eigen::Vector3d::UnitX())),
                         Eigen::Vector3d(1, 0, 2)};
  EXPECT_LT(((kMotion * other) * kPoint - kMotion * (other * kPoint)).norm(), 1e-12);
}

TEST(Similarity3Test, InverseAndProductAgreeWithActionOnPoints) {
  const Similarity3d s = {2.5, kMotion.rotation, kMotion.translation};
  const Similarity3d t = {0.4, kMotion.rotation.conjugate(), Eigen::Vector3d(1, 1, 1)};
  EXPECT_LT((s.Inverse() * (s * kPoint) - kPoint).norm(), 1e-12);
  EXPECT_LT(((s * t) * kPoint - s * (t * kPoint)).norm(), 1e-12);
}

TEST(Similarity3Test, RigidFormProjectsToTheSamePixel) {
  const Similarity3d s = {2.5, kMotion.rotation, kMotion.translation};
  EXPECT_LT(((s * kPoint).hnormalized() - (s.ToRigid() * kPoint).hnormalized()).norm(), 1e-12);
}

TEST(RotationAngleTest, IsTheSameForBothSignsOfTheQuaternion) {
  Eigen::Quaterniond negated = kMotion.rotation;
  negated.coeffs() *= -1;
  EXPECT_NEAR(RotationAngle(kMotion.rotation), 0.7, 1e-12);
  EXPECT_NEAR(RotationAngle(negated), 0.7, 1e-12);
}

TEST(CameraCentreTest, MapsToTheCamerasOrigin) {
  EXPECT_LT((kMotion * CameraCentre(kMotion)).norm(), 1e-12);
}

}  // namespace
}  // namespace corbslam
