// Finds points of the map in an image, near where they are predicted to appear.
#ifndef CORBSLAM_SLAM_MATCHING_PROJECTION_MATCHING_H_
#define CORBSLAM_SLAM_MATCHING_PROJECTION_MATCHING_H_

#include <cstdint>
#include <limits>
#include <vector>

#include "absl/types/span.h"
#include "slam/map/keyframe.h"
#include "slam/matching/match_point.h"

namespace corbslam {

// A window says where to look for what.
struct SearchWindow {
  Eigen::Vector2d pixel;
  // Half side of the square, pixels of the image (the level's scale is in it).
  double radius_px = 0;
  // Predicted disparity; if it is 0 or less, keypoints with any disparity will do.
  double disparity_px = 0;
  int min_octave = 0;
  int max_octave = 0;
  Descriptor descriptor;
  // Angle of the keypoint that the descriptor is from; used where orientation is checked.
  float angle_rad = 0;
};

struct ProjectionMatchingOptions {
  // Hamming distance; a larger one is no match.
  int max_distance = 100;
  // Largest ratio of best to second best, where both lie on the same octave; 1: not checked.
  double max_ratio = 1;
  bool check_orientation = false;
};

inline constexpr uint32_t kNoMatch = std::numeric_limits<uint32_t>::max();

// Returns for each window the index of its keypoint, or kNoMatch. Keypoints for which `taken` (one
// entry a keypoint, or empty) is set are left alone; of windows that want the same keypoint the
// nearest descriptor wins, then the first. A keypoint's disparity, where it has one, must agree
// with the window's within its radius. Pure.
std::vector<uint32_t> MatchWindows(absl::Span<const SearchWindow> windows,
                                   const KeyframePayload& image, absl::Span<const char> taken,
                                   const ProjectionMatchingOptions& options);

// Makes the window of a predicted point: wider where it is seen from aside, and `widening` times
// that (ORB-SLAM, T-RO 2015, V.D).
SearchWindow MakeSearchWindow(const MatchPoint& point, const PredictedView& view, double widening);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_MATCHING_PROJECTION_MATCHING_H_
