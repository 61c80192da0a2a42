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

// Another picture that shows the landmark of a match. Where two cameras stand at one place, every
// scale gives the same pixels in both; pictures from beside them, each placed in its own map, tell
// which it is.
struct SimilaritySight {
  size_t match = 0;
  // Whether the picture is of b's side, and shows x_in_a, or the other way round.
  bool is_of_b = true;
  const Camera* camera = nullptr;  // Outlives the sight.
  Rigid3d camera_from_side;        // From camera b, or a, in the unit of its map.
  Eigen::Vector2d pixel;
  double variance_px2 = 1;
};

struct SimilarityRefinement {
  Similarity3d b_from_a;
  // One entry a match: true if both reprojections are within the bound.
  std::vector<char> is_inlier;
  int inliers = 0;
};

// Squared reprojection errors over their variances: of x_in_a in camera b and of x_in_b in camera
// a. An error is infinite where the point falls behind the camera.
// 99 % bound with two degrees of freedom.
inline constexpr double kMaxChi2OfSimilarity = 9.21;

struct SimilarityErrors {
  double in_a = 0;
  double in_b = 0;
};
SimilarityErrors ReprojectionErrors(const Camera& camera_a, const Camera& camera_b,
                                    const Similarity3d& b_from_a, const SimilarityMatch& match);

// Minimises the reprojection error both ways (Huber's loss at `max_chi2`), drops the matches beyond
// `max_chi2` in either picture, and minimises again without loss. The scale is kept where
// `fix_scale`. The `sights` of inliers count, too, if they are within the bound in the end; those
// of one match on one side together as much as one, for the map knows its point no better.
// INVALID_ARGUMENT for fewer than 3 matches or values that are not finite; FAILED_PRECONDITION
// where fewer than 3 inliers are left. Pure; any thread.
absl::StatusOr<SimilarityRefinement> RefineSimilarity(
    const Camera& camera_a, const Camera& camera_b, absl::Span<const SimilarityMatch> matches,
    const Similarity3d& initial_b_from_a, bool fix_scale, double max_chi2 = kMaxChi2OfSimilarity,
    absl::Span<const SimilaritySight> sights = {});

// Says how well the inliers of a refinement determine what it found: returns the covariance of e
// where the true similarity is Exp(e) * b_from_a, e being (translation in units of b's map,
// rotation in rad, log of scale). Both reprojection errors of each inlier count, linearised, as
// independent ones of the matches' variances, and `sights` as they do in the refinement; where the
// maps have the points wrong the covariance is too small. Rows and columns of a fixed scale are 0.
// FAILED_PRECONDITION where the inliers leave a direction open. Pure; any thread.
absl::StatusOr<Matrix7d> SimilarityCovariance(const Camera& camera_a, const Camera& camera_b,
                                              absl::Span<const SimilarityMatch> matches,
                                              const SimilarityRefinement& refined, bool fix_scale,
                                              absl::Span<const SimilaritySight> sights = {});

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_SIMILARITY_REFINEMENT_H_
