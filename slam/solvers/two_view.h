// Finds the relative pose of two views from pixel matches alone: how a monocular map begins.
#ifndef CORBSLAM_SLAM_SOLVERS_TWO_VIEW_H_
#define CORBSLAM_SLAM_SOLVERS_TWO_VIEW_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "slam/camera/camera.h"
#include "slam/geometry/rigid3.h"
#include "slam/solvers/triangulation.h"

namespace corbslam {

struct PixelMatch {
  Eigen::Vector2d pixel_in_a;
  Eigen::Vector2d pixel_in_b;
};

struct TwoViewOptions {
  // What changes results.
  double max_error_px = 1.0;
  double confidence = 0.999;
  int min_points = 50;
  // Least parallax of the point at rank 50 (or the last) when sorted by parallax, largest first.
  double min_parallax_rad = 0.0175;
  uint64_t seed = 0;
};

struct TwoViewResult {
  // The translation has length 1: two views know no scale.
  Rigid3d b_from_a;
  bool from_homography = false;
  // One entry a match, and its position in the frame of camera a where it is true.
  std::vector<char> is_triangulated;
  std::vector<Eigen::Vector3d> x_in_a;
  int triangulated = 0;
  double parallax_rad = 0;
};

// Estimates an essential matrix, or a homography where the scene is flat (the model with the better
// support, as in ORB-SLAM, Mur-Artal et al., T-RO 2015, IV). INVALID_ARGUMENT for fewer than 8
// matches; NOT_FOUND, with the reason, where geometry is not clear: too few points in front of both
// cameras, too little parallax or two solutions alike. Both cameras share `camera`. The same input
// and seed give the same result; the seed of OpenCV's generator of the calling thread is set.
absl::StatusOr<TwoViewResult> EstimateTwoView(const Camera& camera,
                                              absl::Span<const PixelMatch> matches,
                                              const TwoViewOptions& options);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SOLVERS_TWO_VIEW_H_
