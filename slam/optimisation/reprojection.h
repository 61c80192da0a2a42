// The reprojection residual that pose optimisation and bundle adjustment share.
#ifndef CORBSLAM_SLAM_OPTIMISATION_REPROJECTION_H_
#define CORBSLAM_SLAM_OPTIMISATION_REPROJECTION_H_

#include <Eigen/Core>
#include <cmath>

#include "slam/camera/camera.h"

namespace corbslam {

// 95 % bounds of chi2 with two and three degrees of freedom.
inline constexpr double kChi2Mono = 5.991;
inline constexpr double kChi2Stereo = 7.815;
// A point nearer than this (or behind) is not seen; the limit is small against any scene, also
// without scale.
inline constexpr double kMinDepth = 1e-3;
// The squared, normalised error of an observation that cannot be seen, in multiples of the inliers'
// bound.
inline constexpr double kUnseenFactor = 100;

// What a keypoint measured.
struct PixelMeasurement {
  // The pixel is (x_left, y), and x_right where `has_depth`.
  Eigen::Vector3d pixel = Eigen::Vector3d::Zero();
  double inverse_variance = 1;
  bool has_depth = false;

  double MaxChi2() const { return has_depth ? kChi2Stereo : kChi2Mono; }
};

inline PixelMeasurement MakeMeasurement(const Eigen::Vector2d& pixel, double disparity_px,
                                        double variance_px2) {
  return {{pixel.x(), pixel.y(), pixel.x() - disparity_px}, 1 / variance_px2, disparity_px > 0};
}

// Returns projection minus measurement, px; the third is 0 without depth. The depth must be
// positive.
inline Eigen::Vector3d ReprojectionResidual(const Camera& camera,
                                            const Eigen::Vector3d& x_in_camera,
                                            const PixelMeasurement& measured) {
  const double inverse_z = 1 / x_in_camera.z();
  const double x_px = camera.fx_px * x_in_camera.x() * inverse_z + camera.cx_px;
  const double y_px = camera.fy_px * x_in_camera.y() * inverse_z + camera.cy_px;
  const double right_px = x_px - camera.fx_px * camera.baseline_m * inverse_z;
  return {x_px - measured.pixel.x(), y_px - measured.pixel.y(),
          measured.has_depth ? right_px - measured.pixel.z() : 0};
}

// Returns d residual / d x_in_camera; the third row is 0 without depth.
inline Eigen::Matrix3d ReprojectionJacobian(const Camera& camera,
                                            const Eigen::Vector3d& x_in_camera, bool has_depth) {
  const double inverse_z = 1 / x_in_camera.z();
  const double x = x_in_camera.x() * inverse_z;
  const double y = x_in_camera.y() * inverse_z;
  const double fx = camera.fx_px * inverse_z;
  const double fy = camera.fy_px * inverse_z;
  Eigen::Matrix3d J;
  J << fx, 0, -fx * x, 0, fy, -fy * y, 0, 0, 0;
  if (has_depth) J.row(2) << fx, 0, -fx * x + fx * camera.baseline_m * inverse_z;
  return J;
}

// Returns d residual / d (translation, rotation) of a perturbation of the camera's pose on the
// left: x_in_camera -> x_in_camera + translation + rotation x x_in_camera.
inline Eigen::Matrix<double, 3, 6> PoseJacobian(const Eigen::Matrix3d& J_x,
                                                const Eigen::Vector3d& x_in_camera) {
  Eigen::Matrix<double, 3, 6> J;
  J.leftCols<3>() = J_x;
  for (int row = 0; row < 3; ++row) {
    J.row(row).tail<3>() = x_in_camera.cross(J_x.row(row).transpose()).transpose();
  }
  return J;
}

// Huber's loss of a squared, normalised error `chi2` with its corner at `max_chi2`: the cost, and
// the weight that makes least squares of it (its derivative).
struct RobustCost {
  double cost = 0;
  double weight = 1;
};
inline RobustCost HuberCost(double chi2, double max_chi2) {
  if (chi2 <= max_chi2) return {chi2, 1};
  const double root = std::sqrt(max_chi2 * chi2);
  return {2 * root - max_chi2, root / chi2};
}

// What an observation costs in a bundle adjustment: by Huber's loss, or its `chi2` itself, and what
// cannot be seen (infinite) a constant, as if kUnseenFactor * max_chi2. The cost of no other is
// beyond that: a point that comes out from behind a camera is for a moment projected far beyond all
// pictures, and all poses and points take their steps together. If it cost more than being behind,
// none of them could take one.
inline RobustCost ObservationLoss(double chi2, double max_chi2, bool robust) {
  const double unseen = kUnseenFactor * max_chi2;
  const bool is_constant = !(chi2 < unseen);
  const double counted = is_constant ? unseen : chi2;
  RobustCost loss = robust ? HuberCost(counted, max_chi2) : RobustCost{counted, 1};
  if (is_constant) loss.weight = 0;
  return loss;
}

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_REPROJECTION_H_
