// A bundle adjustment as flat arrays, which both solvers take.
#ifndef CORBSLAM_SLAM_OPTIMISATION_BUNDLE_PROBLEM_H_
#define CORBSLAM_SLAM_OPTIMISATION_BUNDLE_PROBLEM_H_

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "slam/camera/camera.h"
#include "slam/geometry/lie.h"
#include "slam/optimisation/reprojection.h"

namespace corbslam {

struct BundlePose {
  Eigen::Matrix3d R;  // Rotation of camera_from_map.
  Eigen::Vector3d t;
  const Camera* camera = nullptr;

  Eigen::Vector3d ToCamera(const Eigen::Vector3d& x_in_map) const { return R * x_in_map + t; }
};

struct BundleObservation {
  uint32_t pose = 0;
  uint32_t point = 0;
  PixelMeasurement measured;
  bool is_used = true;
};

// poses[0, free_poses) and points[0, free_points) move, the others stay. Observations are sorted
// by point, and within a point by pose.
struct BundleProblem {
  std::vector<BundlePose> poses;
  std::vector<Eigen::Vector3d> points;
  uint32_t free_poses = 0;
  uint32_t free_points = 0;
  std::vector<BundleObservation> observations;
};

struct MinimiseOptions {
  int max_iterations = 10;
  bool robust = true;
  int threads = 1;
  // Called after every iteration with its number from 1; false stops. May be null.
  std::function<bool(int iteration)> keep_going;
  // Relative change of cost at which the minimum counts as reached.
  double converged_cost_change = 1e-5;
};

struct MinimiseSummary {
  // Number of steps tried, taken or not.
  int iterations = 0;
  // 0.5 * sum of (robust) squared errors over variances.
  double initial_cost = 0;
  double final_cost = 0;
  bool cancelled = false;
};

// Returns the squared error over variance; infinite behind the camera.
double ObservationChi2(const BundleProblem& problem, const BundleObservation& observation);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_BUNDLE_PROBLEM_H_
