// A bundle adjustment as flat arrays, and the solver of its normal equations' shape.
//
// Our own solver, not Ceres: with poses of six and residuals of three parameters Ceres has no
// compiled specialisation of its Schur eliminator, and the general one takes several times as long
// as these fixed-size blocks. Method: Levenberg-Marquardt with the points eliminated first (Triggs
// et al., "Bundle Adjustment - A Modern Synthesis", 1999, 6.1).
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
  Eigen::Matrix3d R;  // camera_from_map
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
};

struct MinimiseSummary {
  int iterations = 0;
  // 0.5 * sum of (robust) squared errors over variances.
  double initial_cost = 0;
  double final_cost = 0;
  bool cancelled = false;
};

// Squared error over variance; infinite behind the camera.
double ObservationChi2(const BundleProblem& problem, const BundleObservation& observation);

// Moves the free poses and points of `problem`; its cost never rises.
MinimiseSummary Minimise(const MinimiseOptions& options, BundleProblem& problem);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_BUNDLE_PROBLEM_H_
