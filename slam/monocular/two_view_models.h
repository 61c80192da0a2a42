// The two models of how pixels of two pictures belong together: a plane's homography, and the
// epipolar geometry of anything. Pixels are in normalised coordinates (of the plane z = 1).
#ifndef CORBSLAM_SLAM_MONOCULAR_TWO_VIEW_MODELS_H_
#define CORBSLAM_SLAM_MONOCULAR_TWO_VIEW_MODELS_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "absl/types/span.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

// A match in normalised coordinates, and the variance of either side's, of the same unit.
struct NormalisedMatch {
  Eigen::Vector2d x_1 = Eigen::Vector2d::Zero();
  Eigen::Vector2d x_2 = Eigen::Vector2d::Zero();
  double variance = 1;
};

// How well a model explains all matches.
struct ModelScore {
  double score = 0;
  std::vector<char> is_inlier;  // One entry a match.
};

// Fits x_2 ~ H x_1 to at least 4 matches (normalised direct linear transform: Hartley and
// Zisserman, Multiple View Geometry, algorithm 4.2); nullopt where they don't determine it.
std::optional<Eigen::Matrix3d> FitHomography(absl::Span<const NormalisedMatch> matches);
// Fits x_2' E x_1 = 0 to at least 8 matches (the normalised 8-point algorithm, 11.1 there), with
// two equal singular values and one of 0; nullopt where they don't determine it.
std::optional<Eigen::Matrix3d> FitEssential(absl::Span<const NormalisedMatch> matches);

// Adds up what errors in both pictures leave of a bound that is the same for both models (ORB-SLAM,
// T-RO 2015, eq. 2): of a homography how far the pixels are apart (5.99, two degrees of freedom),
// of an essential matrix how far from the epipolar line (3.84, one).
ModelScore ScoreHomography(const Eigen::Matrix3d& H, absl::Span<const NormalisedMatch> matches);
ModelScore ScoreEssential(const Eigen::Matrix3d& E, absl::Span<const NormalisedMatch> matches);

// Return the motions two_from_one that a model may come from, with translations of length 1: up to
// four of a homography's (those of both signs of its plane's normal), four of an essential
// matrix's. A homography that is a rotation has none.
std::vector<Rigid3d> MotionsOfHomography(const Eigen::Matrix3d& H);
std::vector<Rigid3d> MotionsOfEssential(const Eigen::Matrix3d& E);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_MONOCULAR_TWO_VIEW_MODELS_H_
