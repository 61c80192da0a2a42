// Gathers a keyframe with what is covisible with it: the part of a map that place verification and
// fusing look at.
#ifndef CORBSLAM_SLAM_VERIFICATION_NEIGHBOURHOOD_H_
#define CORBSLAM_SLAM_VERIFICATION_NEIGHBOURHOOD_H_

#include <vector>

#include "absl/container/btree_set.h"
#include "slam/map/map.h"

namespace corbslam {

// Returns the keyframe first, then its `count` most covisible ones that are not in `except`. Empty
// where `centre` is unknown.
std::vector<const Keyframe*> Neighbourhood(const Map& map, KeyframeId centre, int count,
                                           const absl::btree_set<KeyframeId>& except = {});

// Returns a map of that neighbourhood alone, with the points that it sees and its part of the
// graph; empty where `centre` is unknown.
Map ViewAround(const Map& map, KeyframeId centre, int count);

// Returns the points that any of the keyframes sees, sorted by id, each once.
std::vector<const MapPoint*> PointsSeenBy(const Map& map,
                                          const std::vector<const Keyframe*>& keyframes);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_VERIFICATION_NEIGHBOURHOOD_H_
