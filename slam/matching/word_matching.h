// Pairs keypoints of two keyframes that look alike, compared only within the same node of the
// vocabulary tree (direct index; Galvez-Lopez and Tardos, T-RO 2012, section V).
#ifndef CORBSLAM_SLAM_MATCHING_WORD_MATCHING_H_
#define CORBSLAM_SLAM_MATCHING_WORD_MATCHING_H_

#include <cstdint>
#include <utility>
#include <vector>

#include "slam/map/keyframe.h"

namespace corbslam {

struct WordMatchingOptions {
  // Hamming distance of 256 bits; a larger one is no match.
  int max_distance = 50;
  // The best must be below this share of the second best of the same node (Lowe, IJCV 2004).
  double max_ratio = 0.75;
  // True: only keypoints that observe a map point, on that side.
  bool need_points_a = true;
  bool need_points_b = true;
  // Keep only the three most frequent differences of orientation, of 30 equal bins.
  bool check_orientation = true;
};

// Returns pairs (keypoint of a, keypoint of b), ascending; a keypoint occurs once at most. It uses
// the node ids of both keyframes' direct index and nothing else of their words; where one has none,
// every keypoint is compared with every other. Pure.
std::vector<std::pair<uint32_t, uint32_t>> MatchByWords(const Keyframe& a, const Keyframe& b,
                                                        const WordMatchingOptions& options = {});

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_MATCHING_WORD_MATCHING_H_
