// The one view that every algorithm of fusion reads: the owners' graphs with fusion's poses,
// positions and landmarks, as a Map in an island's frame.
#ifndef CORBSLAM_MAP_STORE_VIEW_ISLAND_VIEW_H_
#define CORBSLAM_MAP_STORE_VIEW_ISLAND_VIEW_H_

#include <map>
#include <set>
#include <vector>

#include "absl/status/statusor.h"
#include "map_store/state/mission_state.h"
#include "map_store/view/long_read.h"
#include "map_store/view/placement.h"
#include "slam/map/map.h"

namespace corbslam::map_store {

// A snapshot: shares the payloads, nothing else, with the state that it was made of. Its keyframes
// are those that there were when it was begun, what they see may be a little newer.
struct IslandSnapshot {
  IslandId island;
  uint64_t revision = 0;
  uint64_t generation = 0;
  uint64_t version_of_owners = 0;
  // In the island's frame; camera units rescaled to the island's. Landmarks are their survivors.
  Map view{Covisibility::kGiven};
  // Of the view's keyframes: with their own scales, and the local poses they were derived from.
  IslandPoses poses;
  std::map<KeyframeId, Rigid3d> local_poses;
  // Placed keyframes that were treated as if they were not.
  Unplaced unplaced;
};

// What becomes of observations that fusion has rejected before.
enum class Rejected { kLeaveOut, kTryAgain };

// The whole island, for an adjustment: all keyframes that were not culled, all points that they
// see, and no covisibility. ABORTED: as `read` says.
absl::StatusOr<IslandSnapshot> TakeWholeSnapshot(const MissionState& state, const Island& island,
                                                 Unplaced unplaced, Rejected rejected,
                                                 LongRead& read);

// The island's graph, for fusing: all keyframes with their covisibility, but of the points only
// those that the neighbourhoods of `centres` (keyframes; unknown ones are skipped) see, with all
// their observations, and the `named` ones. ABORTED: as `read` says.
absl::StatusOr<IslandSnapshot> TakeGraphSnapshot(const MissionState& state, const Island& island,
                                                 Unplaced unplaced,
                                                 const std::set<KeyframeId>& centres,
                                                 int neighbourhood,
                                                 const std::set<MapPointId>& named, LongRead& read);

// Only some keyframes of one island, unknown ones left out, and what they see. Covisibility is what
// owners counted within their local maps. ABORTED: as `read` says.
absl::StatusOr<Map> BuildPartialView(const MissionState& state,
                                     const std::set<KeyframeId>& keyframes, LongRead& read);

// One entry a keypoint: the landmark or point that it sees. Only what lies in the same island as
// the keyframe.
std::vector<MapPointId> ObservedPoints(const MissionState& state, const LocalMapState& local_map,
                                       const Keyframe& keyframe,
                                       Rejected rejected = Rejected::kLeaveOut);

// How many keypoints see one of these: as many as ObservedPoints has valid ids, without naming
// them.
size_t CountObservedPoints(const MissionState& state, const LocalMapState& local_map,
                           const Keyframe& keyframe);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_ISLAND_VIEW_H_
