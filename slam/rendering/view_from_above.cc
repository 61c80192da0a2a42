#include "slam/rendering/view_from_above.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace corbslam {
namespace {

// Below this the cameras' y axes cancel each other out and say nothing of what is below.
constexpr double kLeastMeanAxis = 0.3;
// In extents of the paths: how far points are shown as they are, and the most of them, as where a
// camera on a desk looks into a room.
constexpr double kNear = 1.4;
constexpr double kFar = 8;

Eigen::Matrix3d MotionCovariance(const std::vector<Rigid3d>& world_from_cameras) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Rigid3d& pose : world_from_cameras) mean += pose.translation;
  mean /= static_cast<double>(world_from_cameras.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Rigid3d& pose : world_from_cameras) {
    const Eigen::Vector3d offset = pose.translation - mean;
    covariance += offset * offset.transpose();
  }
  return covariance;
}

// Returns the eigenvectors by growing eigenvalue.
Eigen::Matrix3d PrincipalAxes(const Eigen::Matrix3d& covariance) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors();
}

Eigen::Vector3d DownDirection(const std::vector<Rigid3d>& world_from_cameras,
                              const Eigen::Matrix3d& covariance) {
  Eigen::Vector3d mean_y = Eigen::Vector3d::Zero();
  for (const Rigid3d& pose : world_from_cameras) {
    mean_y += pose.rotation * Eigen::Vector3d::UnitY();
  }
  mean_y /= static_cast<double>(world_from_cameras.size());
  if (mean_y.norm() >= kLeastMeanAxis) return mean_y.normalized();
  return PrincipalAxes(covariance).col(0);
}

// Returns the value that `share` of the values lie below.
double Quantile(std::vector<double> values, double share) {
  const auto index = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + index, values.end());
  return values[static_cast<size_t>(index)];
}

}  // namespace

PlaneFromWorld LookFromAbove(const std::vector<Rigid3d>& world_from_cameras) {
  const Eigen::Matrix3d covariance = MotionCovariance(world_from_cameras);
  const Eigen::Vector3d down = DownDirection(world_from_cameras, covariance);
  const Eigen::Matrix3d flatten = Eigen::Matrix3d::Identity() - down * down.transpose();
  Eigen::Vector3d right = flatten * PrincipalAxes(flatten * covariance * flatten).col(2);
  // A camera that never moved has no longest motion.
  if (right.norm() < 1e-6) right = down.unitOrthogonal();
  right.normalize();
  // The motion runs from left to right.
  const Eigen::Vector3d motion =
      world_from_cameras.back().translation - world_from_cameras.front().translation;
  if (right.dot(motion) < 0) right = -right;
  PlaneFromWorld plane_from_world;
  plane_from_world << right.transpose(), down.cross(right).transpose();
  return plane_from_world;
}

Bounds ChooseBounds(const std::vector<Eigen::Vector2d>& paths,
                    const std::vector<Eigen::Vector2d>& points) {
  Bounds bounds{paths.front(), paths.front()};
  for (const Eigen::Vector2d& x : paths) {
    bounds.low = bounds.low.cwiseMin(x);
    bounds.high = bounds.high.cwiseMax(x);
  }
  const double extent = std::max(bounds.Size().maxCoeff(), 1e-3);
  const Bounds near{bounds.low.array() - kNear * extent, bounds.high.array() + kNear * extent};
  const Bounds far{bounds.low.array() - kFar * extent, bounds.high.array() + kFar * extent};
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> values;
    for (const Eigen::Vector2d& x : points) {
      if (x.allFinite()) values.push_back(x[axis]);
    }
    if (values.empty()) break;
    const double low = std::min(near.low[axis], std::max(far.low[axis], Quantile(values, 0.1)));
    const double high = std::max(near.high[axis], std::min(far.high[axis], Quantile(values, 0.9)));
    bounds.low[axis] = std::min(bounds.low[axis], std::max(low, Quantile(values, 0.02)));
    bounds.high[axis] = std::max(bounds.high[axis], std::min(high, Quantile(values, 0.98)));
  }
  const double margin = 0.05 * std::max(bounds.Size().maxCoeff(), extent);
  bounds.low.array() -= margin;
  bounds.high.array() += margin;
  return bounds;
}

double RoundLength(double most) {
  const double power = std::pow(10.0, std::floor(std::log10(most)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= most) return factor * power;
  }
  return power;
}

}  // namespace corbslam
