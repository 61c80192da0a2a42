// Similarities as parameter blocks of Ceres.
#ifndef CORBSLAM_SLAM_OPTIMISATION_SIMILARITY_MANIFOLD_H_
#define CORBSLAM_SLAM_OPTIMISATION_SIMILARITY_MANIFOLD_H_

#include <ceres/manifold.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>

#include "slam/geometry/lie.h"

namespace corbslam {

// The block holds (x, y, z, w) of the quaternion, translation, scale.
using SimilarityBlock = std::array<double, 8>;

inline SimilarityBlock ToBlock(const Similarity3d& s) {
  return {s.rotation.x(),    s.rotation.y(),    s.rotation.z(),    s.rotation.w(),
          s.translation.x(), s.translation.y(), s.translation.z(), s.scale};
}

inline Similarity3d FromBlock(const double* block) {
  return {block[7], Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(block)),
          Eigen::Vector3d(block[4], block[5], block[6])};
}

// Perturbs on the left: Exp(delta) * S, by 6 (scale kept) or 7 parameters. Cost functions write
// their derivatives by delta into the first columns of their Jacobians and zero into the others;
// PlusJacobian only picks them. So these blocks work with our cost functions alone.
template <int kTangent>
class LeftPerturbation : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 8; }
  int TangentSize() const override { return kTangent; }

  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    Vector7d tangent = Vector7d::Zero();
    tangent.head<kTangent>() = Eigen::Map<const Eigen::Matrix<double, kTangent, 1>>(delta);
    const SimilarityBlock moved = ToBlock(ExpSim3(tangent) * FromBlock(x));
    std::copy(moved.begin(), moved.end(), x_plus_delta);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 8, kTangent, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    const Vector7d tangent = LogSim3(FromBlock(y) * FromBlock(x).Inverse());
    Eigen::Map<Eigen::Matrix<double, kTangent, 1>>{y_minus_x} = tangent.head<kTangent>();
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, kTangent, 8, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_SIMILARITY_MANIFOLD_H_
