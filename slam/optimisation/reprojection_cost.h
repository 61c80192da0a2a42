// The cost of one observation in a bundle adjustment by Ceres.
#ifndef CORBSLAM_SLAM_OPTIMISATION_REPROJECTION_COST_H_
#define CORBSLAM_SLAM_OPTIMISATION_REPROJECTION_COST_H_

#include <ceres/sized_cost_function.h>

#include <Eigen/Core>
#include <cmath>

#include "slam/camera/camera.h"
#include "slam/geometry/lie.h"
#include "slam/optimisation/pose_manifold.h"
#include "slam/optimisation/reprojection.h"

namespace corbslam {

// The residuals, over their standard deviation, are (x_left, y), and with kResiduals = 3 also
// x_right. The blocks are camera_from_map as a PoseBlock of unit length, and x_in_map. A point that
// the camera cannot see costs a constant. The Jacobian is that of all seven numbers of the pose;
// the manifold makes six of them.
template <int kResiduals>
class ReprojectionCost : public ceres::SizedCostFunction<kResiduals, 7, 3> {
 public:
  static_assert(kResiduals == 2 || kResiduals == 3);

  // `camera` must outlive this.
  ReprojectionCost(const Camera& camera, const PixelMeasurement& measured)
      : camera_(&camera), measured_(measured), root_weight_(std::sqrt(measured.inverse_variance)) {
    measured_.has_depth = kResiduals == 3;
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const Eigen::Vector3d> v(parameters[0]);
    const double w = parameters[0][3];
    const Eigen::Map<const Eigen::Vector3d> x_in_map(parameters[1]);
    const Eigen::Matrix3d R = RotationMatrix(v, w);
    const Eigen::Vector3d x = R * x_in_map + Eigen::Map<const Eigen::Vector3d>(parameters[0] + 4);
    Eigen::Map<Residual> r(residuals);
    if (!(x.z() > kMinDepth)) {
      r = std::sqrt(kUnseenFactor * measured_.MaxChi2()) * Residual::Unit(0);
      SetZero(jacobians);
      return true;
    }
    r = root_weight_ * ReprojectionResidual(*camera_, x, measured_).template head<kResiduals>();
    if (jacobians == nullptr) return true;
    const Eigen::Matrix<double, kResiduals, 3> J_x =
        root_weight_ *
        ReprojectionJacobian(*camera_, x, measured_.has_depth).template topRows<kResiduals>();
    if (jacobians[0] != nullptr) {
      PoseMatrix J(jacobians[0]);
      J.template leftCols<4>().noalias() = J_x * RotatedByQuaternion(v, w, x_in_map);
      J.template rightCols<3>() = J_x;
    }
    if (jacobians[1] != nullptr) PointMatrix(jacobians[1]).noalias() = J_x * R;
    return true;
  }

 private:
  using Residual = Eigen::Matrix<double, kResiduals, 1>;
  using PoseMatrix = Eigen::Map<Eigen::Matrix<double, kResiduals, 7, Eigen::RowMajor>>;
  using PointMatrix = Eigen::Map<Eigen::Matrix<double, kResiduals, 3, Eigen::RowMajor>>;

  // Returns the matrix of x + 2 w v x x + 2 v x (v x x) for every x; for unit quaternions it is the
  // rotation.
  static Eigen::Matrix3d RotationMatrix(const Eigen::Vector3d& v, double w) {
    return (1 - 2 * v.squaredNorm()) * Eigen::Matrix3d::Identity() + 2 * w * Skew(v) +
           2 * v * v.transpose();
  }
  // Returns d RotationMatrix(v, w) x / d (v, w).
  static Eigen::Matrix<double, 3, 4> RotatedByQuaternion(const Eigen::Vector3d& v, double w,
                                                         const Eigen::Vector3d& x) {
    Eigen::Matrix<double, 3, 4> J;
    J.leftCols<3>() = 2 * (v.dot(x) * Eigen::Matrix3d::Identity() + v * x.transpose() -
                           2 * x * v.transpose() - w * Skew(x));
    J.col(3) = 2 * v.cross(x);
    return J;
  }
  static void SetZero(double** jacobians) {
    if (jacobians == nullptr) return;
    if (jacobians[0] != nullptr) PoseMatrix(jacobians[0]).setZero();
    if (jacobians[1] != nullptr) PointMatrix(jacobians[1]).setZero();
  }

  const Camera* camera_;
  PixelMeasurement measured_;
  double root_weight_;
};

using MonoReprojectionCost = ReprojectionCost<2>;
using StereoReprojectionCost = ReprojectionCost<3>;

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_REPROJECTION_COST_H_
