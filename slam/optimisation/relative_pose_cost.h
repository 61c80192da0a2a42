// The cost of one edge of a pose graph.
#ifndef CORBSLAM_SLAM_OPTIMISATION_RELATIVE_POSE_COST_H_
#define CORBSLAM_SLAM_OPTIMISATION_RELATIVE_POSE_COST_H_

#include <ceres/sized_cost_function.h>

#include <Eigen/Core>

#include "slam/geometry/lie.h"
#include "slam/optimisation/similarity_manifold.h"

namespace corbslam {

// The residual is R * log(b_from_a * a * b^-1), of 6 (rigid) or 7 components, R being upper
// triangular; the blocks are a and b with LeftPerturbation<kTangent>.
template <int kTangent>
class RelativePoseCost : public ceres::SizedCostFunction<kTangent, 8, 8> {
 public:
  RelativePoseCost(const Similarity3d& b_from_a, const Matrix7d& R)
      : b_from_a_(b_from_a), R_(R.topLeftCorner<kTangent, kTangent>()) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Similarity3d error =
        b_from_a_ * FromBlock(parameters[0]) * FromBlock(parameters[1]).Inverse();
    const Vector7d tangent = LogSim3(error);
    Eigen::Map<Eigen::Matrix<double, kTangent, 1>>{residuals} = R_ * tangent.head<kTangent>();
    if (jacobians == nullptr) return true;
    const Matrix7d J_inverse = InverseLeftJacobian(tangent);
    if (jacobians[0] != nullptr) Write(J_inverse * AdjointSim3(b_from_a_), jacobians[0]);
    if (jacobians[1] != nullptr) Write(-J_inverse * AdjointSim3(error), jacobians[1]);
    return true;
  }

 private:
  static Matrix7d InverseLeftJacobian(const Vector7d& tangent) {
    if constexpr (kTangent == 7) return InverseLeftJacobianSim3(tangent);
    Matrix7d J = Matrix7d::Identity();
    J.topLeftCorner<6, 6>() = InverseLeftJacobianSE3(tangent.head<6>());
    return J;
  }
  void Write(const Matrix7d& J, double* jacobian) const {
    Eigen::Map<Eigen::Matrix<double, kTangent, 8, Eigen::RowMajor>> out(jacobian);
    out.setZero();
    out.template leftCols<kTangent>() = R_ * J.topLeftCorner<kTangent, kTangent>();
  }

  Similarity3d b_from_a_;
  Eigen::Matrix<double, kTangent, kTangent> R_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_RELATIVE_POSE_COST_H_
