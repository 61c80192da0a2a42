// Says which keypoints of an overlap's two keyframes show the same, for people to look at.
#ifndef CORBSLAM_MAP_STORE_FUSION_OVERLAP_MATCHES_H_
#define CORBSLAM_MAP_STORE_FUSION_OVERLAP_MATCHES_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "map_store/state/mission_state.h"
#include "slam/exchange/overlap.h"

namespace corbslam::map_store {

inline constexpr size_t kMaxOverlapMatches = 1000;

// What matching needs of the mission's state: it is copied under the state's lock, and matched
// without.
struct OverlapSides {
  Overlap overlap;
  Keyframe query;
  Keyframe candidate;
  // Points of the query's keypoints, in the query's map; by keypoint.
  std::vector<std::optional<Eigen::Vector3d>> query_points;
  // Keypoints that see the same landmark after fusion.
  std::vector<std::pair<uint32_t, uint32_t>> of_landmarks;
};

// Returns nullopt where one of the two keyframes is not there any more.
std::optional<OverlapSides> TakeOverlapSides(const MissionState& state, const Overlap& overlap);

// Returns pairs (keypoint of the query, keypoint of the candidate), ascending; a keypoint of either
// is in one pair at most. First come those that see the same landmark. Of an overlap that was
// accepted also those whose descriptors are alike where its similarity puts them; of one that was
// refused, and of whose keyframes no landmark is the same, those that look alike, wherever they
// lie, which verification began with. Pure.
std::vector<std::pair<uint32_t, uint32_t>> MatchOverlap(const OverlapSides& sides);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FUSION_OVERLAP_MATCHES_H_
