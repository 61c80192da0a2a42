#include "slam/optimisation/scale_gauge.h"

#include <algorithm>
#include <cmath>

namespace corbslam {
namespace {

Eigen::Vector3d CentreOf(const BundlePose& pose) { return -(pose.R.transpose() * pose.t); }

bool HasSize(const BundleProblem& problem) {
  if (problem.poses.size() != problem.free_poses + 1) return true;
  if (problem.points.size() != problem.free_points) return true;
  return std::any_of(problem.observations.begin(), problem.observations.end(),
                     [](const BundleObservation& o) { return o.measured.has_depth; });
}

// The root of the mean square distance of free cameras from the fixed one, which is the last.
double ExtentOf(const BundleProblem& problem) {
  const Eigen::Vector3d fixed = CentreOf(problem.poses.back());
  double sum2 = 0;
  for (uint32_t i = 0; i < problem.free_poses; ++i) {
    sum2 += (CentreOf(problem.poses[i]) - fixed).squaredNorm();
  }
  return std::sqrt(sum2 / std::max<uint32_t>(problem.free_poses, 1));
}

}  // namespace

ScaleGauge::ScaleGauge(const BundleProblem& problem) {
  if (HasSize(problem)) return;
  const double extent = ExtentOf(problem);
  if (extent > 0) extent_ = extent;
}

void ScaleGauge::Hold(BundleProblem& problem) const {
  if (!is_free()) return;
  const double scale = *extent_ / ExtentOf(problem);
  if (!std::isfinite(scale) || !(scale > 0)) return;
  const Eigen::Vector3d fixed = CentreOf(problem.poses.back());
  for (uint32_t i = 0; i < problem.free_poses; ++i) {
    BundlePose& pose = problem.poses[i];
    pose.t = -(pose.R * (fixed + scale * (CentreOf(pose) - fixed)));
  }
  for (uint32_t i = 0; i < problem.free_points; ++i) {
    problem.points[i] = fixed + scale * (problem.points[i] - fixed);
  }
}

}  // namespace corbslam
