// Finds the pose of a camera from 3D-2D matches of which many may be wrong, without an initial
// guess.
#ifndef CORBSLAM_SLAM_SOLVERS_PNP_RANSAC_H_
#define CORBSLAM_SLAM_SOLVERS_PNP_RANSAC_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "slam/camera/camera.h"
#include "slam/optimisation/pose_optimisation.h"

namespace corbslam {

struct PnpRansacOptions {
  // What changes results.
  int min_inliers = 10;
  // Bound of squared reprojection error over variance (95 % of two degrees of freedom).
  double max_chi2 = 5.991;
  double confidence = 0.99;
  int max_iterations = 300;
  uint64_t seed = 0;
};

// Estimates a pose by P3P on samples of four (the fourth chooses among P3P's solutions), judged by
// reprojection errors in the left picture. OptimisePose, which also uses disparities, refines the
// best, and `is_inlier` is that of the refined pose. NOT_FOUND, with the counts, where fewer than
// `min_inliers` agree; INVALID_ARGUMENT for fewer than 4 observations or values that are not
// finite. The same input and seed give the same result. Pure; any thread.
absl::StatusOr<PoseEstimate> EstimatePose(const Camera& camera,
                                          absl::Span<const PoseObservation> observations,
                                          const PnpRansacOptions& options);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SOLVERS_PNP_RANSAC_H_
