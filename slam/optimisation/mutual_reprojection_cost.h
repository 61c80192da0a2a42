// The cost of one match under a similarity between two cameras.
#ifndef CORBSLAM_SLAM_OPTIMISATION_MUTUAL_REPROJECTION_COST_H_
#define CORBSLAM_SLAM_OPTIMISATION_MUTUAL_REPROJECTION_COST_H_

#include <ceres/sized_cost_function.h>

#include <Eigen/Core>
#include <cmath>

#include "slam/geometry/lie.h"
#include "slam/optimisation/reprojection.h"
#include "slam/optimisation/similarity_manifold.h"

namespace corbslam {

// The residuals are the reprojection error of `x_in_source` in the target camera, over its standard
// deviation. The block is b_from_a with LeftPerturbation<6 or 7>; the target is camera b, or a
// where kInverse, or another camera beside that one. Evaluation fails (so that the step is refused)
// where the point falls behind the target.
template <bool kInverse>
class MutualReprojectionCost : public ceres::SizedCostFunction<2, 8> {
 public:
  // `target` must outlive this. It stands at `target_from_side` to camera b, or a where kInverse.
  MutualReprojectionCost(const Camera& target, const Eigen::Vector3d& x_in_source,
                         const Eigen::Vector2d& pixel_in_target, double variance_px2,
                         const Rigid3d& target_from_side = Rigid3d::Identity())
      : target_(target),
        target_from_side_(target_from_side),
        x_in_source_(x_in_source),
        measured_(MakeMeasurement(pixel_in_target, 0, variance_px2)) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Similarity3d b_from_a = FromBlock(parameters[0]);
    const Similarity3d a_from_b = b_from_a.Inverse();
    const Eigen::Vector3d x_in_side = (kInverse ? a_from_b : b_from_a) * x_in_source_;
    const Eigen::Vector3d x = target_from_side_ * x_in_side;
    if (!(x.z() > kMinDepth)) return false;
    const double root_weight = std::sqrt(measured_.inverse_variance);
    Eigen::Map<Eigen::Vector2d>{residuals} =
        root_weight * ReprojectionResidual(target_, x, measured_).head<2>();
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    // J_y is d(Exp(delta) * y) / d delta at y in camera b.
    const Eigen::Vector3d& y = kInverse ? x_in_source_ : x_in_side;
    Eigen::Matrix<double, 3, 7> J_y;
    J_y << Eigen::Matrix3d::Identity(), -Skew(y), y;
    if (kInverse) J_y = -(a_from_b.scale * a_from_b.rotation.toRotationMatrix() * J_y).eval();
    J_y = (target_from_side_.rotation.toRotationMatrix() * J_y).eval();
    Eigen::Map<Eigen::Matrix<double, 2, 8, Eigen::RowMajor>> J(jacobians[0]);
    J.setZero();
    J.leftCols<7>() = root_weight * ReprojectionJacobian(target_, x, false).topRows<2>() * J_y;
    return true;
  }

 private:
  const Camera& target_;
  Rigid3d target_from_side_;
  Eigen::Vector3d x_in_source_;
  PixelMeasurement measured_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_MUTUAL_REPROJECTION_COST_H_
