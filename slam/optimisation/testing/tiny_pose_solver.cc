#include "slam/optimisation/testing/tiny_pose_solver.h"

#include <ceres/tiny_solver.h>

#include <Eigen/LU>
#include <cmath>
#include <cstddef>

#include "slam/geometry/lie.h"

namespace corbslam::testing {
namespace {

constexpr int kRounds = 4;
constexpr int kRobustRounds = 2;
constexpr int kIterations = 10;
constexpr int kMinObservations = 3;

// The factor g makes |g r|^2 = Huber(|r|^2); the derivative is that of g by |r|^2.
struct Scaling {
  double g = 1;
  double derivative = 0;
};
Scaling HuberScaling(double chi2, double max_chi2) {
  const RobustCost loss = HuberCost(chi2, max_chi2);
  if (chi2 <= max_chi2) return {};
  const double g = std::sqrt(loss.cost / chi2);
  return {g, (loss.weight * chi2 - loss.cost) / (2 * g * chi2 * chi2)};
}

Rigid3d Moved(const Vector6d& parameters, const Rigid3d& base) {
  return Rigid3d{ExpSO3(parameters.tail<3>()), parameters.head<3>()} * base;
}

bool IsInlier(const Camera& camera, const Rigid3d& pose, const Eigen::Vector3d& x_in_map,
              const PixelMeasurement& pixel) {
  const Eigen::Vector3d x = pose * x_in_map;
  return x.z() > kMinDepth &&
         ReprojectionResidual(camera, x, pixel).squaredNorm() * pixel.inverse_variance <=
             pixel.MaxChi2();
}

}  // namespace

bool TinyPoseCost::operator()(const double* parameters, double* residuals, double* jacobian) const {
  const Eigen::Map<const Eigen::Vector3d> translation(parameters);
  const Eigen::Vector3d rotation = Eigen::Map<const Eigen::Vector3d>(parameters + 3);
  const Eigen::Matrix3d R = ExpSO3(rotation).toRotationMatrix();
  const Eigen::Matrix3d J_left = InverseLeftJacobianSO3(rotation).inverse();
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 6>> J(jacobian, jacobian ? NumResiduals() : 0,
                                                         6);
  for (size_t i = 0; i < measurements.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(3 * i);
    const PixelMeasurement& pixel = measurements[i].pixel;
    const Eigen::Vector3d turned = R * measurements[i].x_in_base;
    const Eigen::Vector3d x = turned + translation;
    Eigen::Map<Eigen::Vector3d> residual(residuals + row);
    const double root_weight = std::sqrt(pixel.inverse_variance);
    if (!(x.z() > kMinDepth)) {
      residual = std::sqrt(kUnseenFactor * pixel.MaxChi2()) * Eigen::Vector3d::UnitX();
      if (jacobian != nullptr) J.middleRows<3>(row).setZero();
      continue;
    }
    const Eigen::Vector3d r = root_weight * ReprojectionResidual(camera, x, pixel);
    const Scaling scaling = robust ? HuberScaling(r.squaredNorm(), pixel.MaxChi2()) : Scaling{};
    residual = scaling.g * r;
    if (jacobian == nullptr) continue;
    const Eigen::Matrix3d J_r =
        scaling.g * Eigen::Matrix3d::Identity() + 2 * scaling.derivative * r * r.transpose();
    const Eigen::Matrix3d J_x =
        J_r * root_weight * ReprojectionJacobian(camera, x, pixel.has_depth);
    J.block<3, 3>(row, 0) = J_x;
    J.block<3, 3>(row, 3) = -J_x * Skew(turned) * J_left;
  }
  return true;
}

PoseEstimate OptimisePoseTiny(const Camera& camera, const Rigid3d& initial_camera_from_map,
                              absl::Span<const PoseObservation> observations) {
  std::vector<PixelMeasurement> pixels;
  for (const PoseObservation& o : observations) {
    pixels.push_back(MakeMeasurement(o.pixel, o.disparity_px, o.variance_px2));
  }
  PoseEstimate estimate{initial_camera_from_map, std::vector<char>(observations.size(), 1),
                        static_cast<int>(observations.size())};
  ceres::TinySolver<TinyPoseCost> solver;
  solver.options.max_num_iterations = kIterations;
  // TinySolver compares the cost's change itself with the tolerance, not its share.
  solver.options.function_tolerance = 1e-6 * static_cast<double>(observations.size());
  for (int round = 0; round < kRounds && estimate.inliers >= kMinObservations; ++round) {
    const Rigid3d base = round < kRobustRounds ? initial_camera_from_map : estimate.camera_from_map;
    TinyPoseCost cost{camera, {}, round < kRobustRounds};
    for (size_t i = 0; i < observations.size(); ++i) {
      if (!estimate.is_inlier[i]) continue;
      cost.measurements.push_back({base * observations[i].x_in_map, pixels[i]});
    }
    Vector6d parameters = Vector6d::Zero();
    solver.Solve(cost, &parameters);
    estimate.camera_from_map = Moved(parameters, base);
    estimate.inliers = 0;
    for (size_t i = 0; i < observations.size(); ++i) {
      const bool fits =
          IsInlier(camera, estimate.camera_from_map, observations[i].x_in_map, pixels[i]);
      estimate.is_inlier[i] = fits ? 1 : 0;
      estimate.inliers += fits ? 1 : 0;
    }
  }
  return estimate;
}

}  // namespace corbslam::testing
