// Finds points of two neighbourhoods that are one landmark.
#ifndef CORBSLAM_SLAM_FUSING_DUPLICATE_SEARCH_H_
#define CORBSLAM_SLAM_FUSING_DUPLICATE_SEARCH_H_

#include <utility>
#include <vector>

#include "slam/map/map.h"

namespace corbslam {

struct DuplicateSearchOptions {
  double radius_px = 4;
  int max_distance = 50;
  bool check_disparity = true;  // True: both sides are metric.
};

// Returns pairs (anchor's point, mover's point), each point at most once, sorted. `known` pairs are
// taken as they are; the rest is found by projecting each side's points into the other side's
// keyframes. All keyframes are of `map`, whose poses and positions are already in one frame. A
// point that both sides see already has no duplicate. Pure.
std::vector<std::pair<MapPointId, MapPointId>> FindDuplicates(
    const Map& map, const std::vector<const Keyframe*>& anchors,
    const std::vector<const Keyframe*>& movers,
    const std::vector<std::pair<MapPointId, MapPointId>>& known,
    const DuplicateSearchOptions& options = {});

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_FUSING_DUPLICATE_SEARCH_H_
