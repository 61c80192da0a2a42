// Rigid motions as parameter blocks of Ceres.
#ifndef CORBSLAM_SLAM_OPTIMISATION_POSE_MANIFOLD_H_
#define CORBSLAM_SLAM_OPTIMISATION_POSE_MANIFOLD_H_

#include <ceres/manifold.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "slam/geometry/lie.h"

namespace corbslam {

// The block holds (x, y, z, w) of the quaternion, then the translation.
using PoseBlock = std::array<double, 7>;

inline PoseBlock ToPoseBlock(const Eigen::Quaterniond& rotation,
                             const Eigen::Vector3d& translation) {
  return {rotation.x(),    rotation.y(),    rotation.z(),   rotation.w(),
          translation.x(), translation.y(), translation.z()};
}

// Perturbs on the left by (translation, rotation): q -> Exp(rotation) q,
// t -> Exp(rotation) t + translation. For a camera's pose that is a motion about the camera itself,
// wherever the map's origin lies.
class PoseManifold : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }

  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    const Eigen::Map<const Eigen::Vector3d> translation(delta);
    const Eigen::Quaterniond turn = ExpSO3(Eigen::Map<const Eigen::Vector3d>(delta + 3));
    const PoseBlock moved =
        ToPoseBlock((turn * Rotation(x)).normalized(), turn * Translation(x) + translation);
    std::copy(moved.begin(), moved.end(), x_plus_delta);
    return true;
  }

  bool PlusJacobian(const double* x, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> J(jacobian);
    J.setZero();
    J.topRightCorner<4, 3>() = QuaternionByTurn(x);
    J.bottomLeftCorner<3, 3>().setIdentity();
    J.bottomRightCorner<3, 3>() = -Skew(Translation(x));
    return true;
  }

  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    const Eigen::Quaterniond turn = Rotation(y) * Rotation(x).conjugate();
    Eigen::Map<Vector6d>{y_minus_x} << Translation(y) - turn * Translation(x), LogSO3(turn);
    return true;
  }

  bool MinusJacobian(const double* x, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> J(jacobian);
    J.setZero();
    // The columns of QuaternionByTurn are orthogonal, of length 1/2.
    const Eigen::Matrix<double, 3, 4> turn_by_quaternion = 4 * QuaternionByTurn(x).transpose();
    J.topLeftCorner<3, 4>() = Skew(Translation(x)) * turn_by_quaternion;
    J.topRightCorner<3, 3>().setIdentity();
    J.bottomLeftCorner<3, 4>() = turn_by_quaternion;
    return true;
  }

 private:
  static Eigen::Quaterniond Rotation(const double* block) {
    return Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(block));
  }
  static Eigen::Vector3d Translation(const double* block) {
    return Eigen::Map<const Eigen::Vector3d>(block + 4);
  }
  // Returns d (x, y, z, w) of Exp(turn) q / d turn at 0.
  static Eigen::Matrix<double, 4, 3> QuaternionByTurn(const double* q) {
    Eigen::Matrix<double, 4, 3> J;
    J << q[3], q[2], -q[1], -q[2], q[3], q[0], q[1], -q[0], q[3], -q[0], -q[1], -q[2];
    return J / 2;
  }
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_POSE_MANIFOLD_H_
