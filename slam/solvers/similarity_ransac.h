// Finds a similarity between two cameras from 3D-3D matches of which many may be wrong.
#ifndef CORBSLAM_SLAM_SOLVERS_SIMILARITY_RANSAC_H_
#define CORBSLAM_SLAM_SOLVERS_SIMILARITY_RANSAC_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "slam/camera/camera.h"
#include "slam/geometry/rigid3.h"
#include "slam/optimisation/similarity_refinement.h"

namespace corbslam {

struct SimilarityRansacOptions {
  // What changes results.
  bool fix_scale = true;
  int min_inliers = 20;
  // Bound of squared reprojection error over variance, in each of both pictures (99 % of two
  // degrees of freedom).
  double max_chi2 = 9.21;
  double confidence = 0.99;
  int max_iterations = 300;
  uint64_t seed = 0;
};

struct SimilarityRansacResult {
  Similarity3d b_from_a;
  // One entry a match.
  std::vector<char> is_inlier;
  int inliers = 0;
};

// Estimates a similarity by Horn's closed form on samples of three, judged by the reprojection
// errors in both pictures; the best is aligned again to all its inliers while that gains any.
// NOT_FOUND, with the counts, where no sample has `min_inliers`; INVALID_ARGUMENT for fewer than 3
// matches. The same input and seed give the same result. Pure; any thread.
absl::StatusOr<SimilarityRansacResult> EstimateSimilarity(const Camera& camera_a,
                                                          const Camera& camera_b,
                                                          absl::Span<const SimilarityMatch> matches,
                                                          const SimilarityRansacOptions& options);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SOLVERS_SIMILARITY_RANSAC_H_
