// Finds the pose of one camera from known points ("motion-only bundle adjustment").
#ifndef CORBSLAM_SLAM_OPTIMISATION_POSE_OPTIMISATION_H_
#define CORBSLAM_SLAM_OPTIMISATION_POSE_OPTIMISATION_H_

#include <Eigen/Core>
#include <vector>

#include "absl/types/span.h"
#include "slam/camera/camera.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

struct PoseObservation {
  Eigen::Vector3d x_in_map;
  Eigen::Vector2d pixel;
  // x_left - x_right; 0 or less for a monocular observation.
  double disparity_px = 0;
  // Variance of each of the observed coordinates (x_left, y and, with disparity, x_right).
  double variance_px2 = 1;
};

struct PoseEstimate {
  Rigid3d camera_from_map;
  // One entry an observation: true if it is in front of the camera and within the 95 % bound of
  // chi2.
  std::vector<char> is_inlier;
  int inliers = 0;
};

// Minimises the robust (Huber) reprojection error from `initial_camera_from_map` in four rounds;
// after each, observations are sorted anew into inliers and outliers (an outlier may come back),
// and the last rounds use the inliers alone, without a robust kernel. With fewer than three
// usable observations the initial pose comes back with what fits it. Pure; any thread. Method:
// ORB-SLAM2 (Mur-Artal and Tardos, T-RO 2017, III.C).
PoseEstimate OptimisePose(const Camera& camera, const Rigid3d& initial_camera_from_map,
                          absl::Span<const PoseObservation> observations);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_POSE_OPTIMISATION_H_
