// The one view that every algorithm of fusion reads: the owners' graphs with fusion's poses,
// positions and landmarks, as a Map in an island's frame.
#ifndef CORBSLAM_MAP_STORE_ISLAND_VIEW_H_
#define CORBSLAM_MAP_STORE_ISLAND_VIEW_H_

#include <map>
#include <set>
#include <vector>

#include "map_store/mission_state.h"
#include "map_store/placement.h"
#include "slam/map/map.h"

namespace corbslam::map_store {

// A snapshot: shares the payloads, nothing else, with the state that it was made of.
struct IslandSnapshot {
  IslandId island;
  uint64_t revision = 0;
  uint64_t generation = 0;
  uint64_t version_of_owners = 0;
  // In the island's frame; camera units rescaled to the island's. Points that no keyframe of the
  // view sees are not in it; landmarks are their survivors.
  Map view;
  // Of the view's keyframes: with their own scales, and the local poses they were derived from.
  IslandPoses poses;
  std::map<KeyframeId, Rigid3d> local_poses;
};

// What becomes of observations that fusion has rejected before.
enum class Rejected { kLeaveOut, kTryAgain };

// The whole island. `unplaced`: see placement.h.
IslandSnapshot TakeIslandSnapshot(const MissionState& state, const Island& island,
                                  const Unplaced& unplaced = {},
                                  Rejected rejected = Rejected::kLeaveOut);

// Only some of the island's keyframes, and what they see.
Map BuildPartialView(const MissionState& state, const Island& island,
                     const std::set<KeyframeId>& keyframes);

// One entry a keypoint: the landmark or point that it sees. Only what lies in the same island as
// the keyframe.
std::vector<MapPointId> ObservedPoints(const MissionState& state, const LocalMapState& local_map,
                                       const Keyframe& keyframe,
                                       Rejected rejected = Rejected::kLeaveOut);

// Landmarks and points that two keyframes of one island both see; 0 across islands.
int CountSharedLandmarks(const MissionState& state, KeyframeId a, KeyframeId b);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ISLAND_VIEW_H_
