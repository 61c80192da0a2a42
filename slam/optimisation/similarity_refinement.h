// Refines a similarity between two cameras from matched points that both maps know.
#ifndef CORBSLAM_SLAM_OPTIMISATION_SIMILARITY_REFINEMENT_H_
#define CORBSLAM_SLAM_OPTIMISATION_SIMILARITY_REFINEMENT_H_

#include <Eigen/Core>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "slam/camera/camera.h"
#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

// The same landmark as each side's map places it, in the frame of that side's camera, and the pixel
// in which that side's camera sees it.
struct SimilarityMatch {
  Eigen::Vector3d x_in_a;
  Eigen::Vector3d x_in_b;
  Eigen::Vector2d pixel_in_a;
  Eigen::Vector2d pixel_in_b;
  double variance_a_px2 = 1;
  double variance_b_px2 = 1;
};

struct SimilarityRefinement {
  Similarity3d b_from_a;
  // One entry a match: true if both reprojections are within the bound.
  std::vector<char> is_inlier;
  int inliers = 0;
};

// Squared reprojection errors over their variances: of x_in_a in camera b and of x_in_b in camera
// a. An error is infinite where the point falls behind the camera.
struct SimilarityErrors {
  double in_a = 0;
  double in_b = 0;
};
SimilarityErrors ReprojectionErrors(const Camera& camera_a, const Camera& camera_b,
                                    const Similarity3d& b_from_a, const SimilarityMatch& match);

// Minimises the reprojection error both ways (Huber's loss at `max_chi2`), drops the matches beyond
// `max_chi2` in either picture, and minimises again without loss. The scale is kept where
// `fix_scale`. INVALID_ARGUMENT for fewer than 3 matches or values that are not finite;
// FAILED_PRECONDITION where fewer than 3 inliers are left. Pure; any thread.
absl::StatusOr<SimilarityRefinement> RefineSimilarity(const Camera& camera_a,
                                                      const Camera& camera_b,
                                                      absl::Span<const SimilarityMatch> matches,
                                                      const Similarity3d& initial_b_from_a,
                                                      bool fix_scale, double max_chi2 = 9.21);

// Says how well the inliers of a refinement determine what it found: returns the covariance of e
// where the true similarity is Exp(e) * b_from_a, e being (translation in units of b's map,
// rotation in rad, log of scale). Both reprojection errors of each inlier count, linearised, as
// independent ones of the matches' variances; where the maps have the points wrong the covariance
// is too small. Rows and columns of a fixed scale are 0. FAILED_PRECONDITION where the inliers
// leave a direction open. Pure; any thread.
absl::StatusOr<Matrix7d> SimilarityCovariance(const Camera& camera_a, const Camera& camera_b,
                                              absl::Span<const SimilarityMatch> matches,
                                              const SimilarityRefinement& refined, bool fix_scale);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_SIMILARITY_REFINEMENT_H_
