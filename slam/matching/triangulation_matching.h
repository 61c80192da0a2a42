// Finds pairs of keypoints of two keyframes that may be a point not in the map yet.
#ifndef CORBSLAM_SLAM_MATCHING_TRIANGULATION_MATCHING_H_
#define CORBSLAM_SLAM_MATCHING_TRIANGULATION_MATCHING_H_

#include <cstdint>
#include <utility>
#include <vector>

#include "slam/map/keyframe.h"

namespace corbslam {

struct TriangulationMatchingOptions {
  int max_distance = 50;
  bool check_orientation = false;
};

// Returns pairs (keypoint of a, keypoint of b), ascending, each keypoint at most once. Paired
// keypoints have no map point, look alike, lie under the same node of the vocabulary tree, and b's
// is within the 95 % bound of a's epipolar line (ORB-SLAM, T-RO 2015, VI.C). Near b's view of a's
// centre (where any line passes) only keypoints with a disparity count. Both keyframes need words;
// without a direct index there are no matches. Pure.
std::vector<std::pair<uint32_t, uint32_t>> MatchForTriangulation(
    const Keyframe& a, const Keyframe& b, const TriangulationMatchingOptions& options = {});

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_MATCHING_TRIANGULATION_MATCHING_H_
