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

// A snapshot of an island. It shares nothing but the payloads with the state that it was made of.
// Its keyframes are those that there were when it was begun; what they see may be a little newer.
struct IslandSnapshot {
  IslandId island;
  uint64_t revision = 0;
  uint64_t generation = 0;
  uint64_t version_of_owners = 0;
  // The graph in the island's frame, with camera units rescaled to the island's. Survivors stand
  // for landmarks.
  Map view{Covisibility::kGiven};
  // The poses of the view's keyframes, with their own scales, and the local poses that they were
  // derived from.
  IslandPoses poses;
  std::map<KeyframeId, Rigid3d> local_poses;
  // Placed keyframes that were treated as if they were not.
  Unplaced unplaced;
};

// What becomes of observations that fusion has rejected before.
enum class Rejected { kLeaveOut, kTryAgain };

// Takes the whole island, for an adjustment: all keyframes that were not culled, all points that
// they see, and no covisibility. Returns ABORTED as `read` does.
absl::StatusOr<IslandSnapshot> TakeWholeSnapshot(const MissionState& state, const Island& island,
                                                 Unplaced unplaced, Rejected rejected,
                                                 LongRead& read);

// Takes the island's graph, for fusing: all keyframes with their covisibility, but of the points
// only the `named` ones and those that the neighbourhoods of `centres` see, with all their
// observations. `centres` are keyframes; unknown ones are skipped. Returns ABORTED as `read` does.
absl::StatusOr<IslandSnapshot> TakeGraphSnapshot(const MissionState& state, const Island& island,
                                                 Unplaced unplaced,
                                                 const std::set<KeyframeId>& centres,
                                                 int neighbourhood,
                                                 const std::set<MapPointId>& named, LongRead& read);

// Builds a view of some keyframes of one island, without unknown ones, and of what they see.
// Covisibility is what owners counted within their local maps. Returns ABORTED as `read` does.
absl::StatusOr<Map> BuildPartialView(const MissionState& state,
                                     const std::set<KeyframeId>& keyframes, LongRead& read);

// Returns for each keypoint the landmark or point that it sees, if that lies in the keyframe's
// island; else an invalid id.
std::vector<MapPointId> ObservedPoints(const MissionState& state, const LocalMapState& local_map,
                                       const Keyframe& keyframe,
                                       Rejected rejected = Rejected::kLeaveOut);

// Counts the keypoints that see one of these, without naming them: as many as ObservedPoints has
// valid ids.
size_t CountObservedPoints(const MissionState& state, const LocalMapState& local_map,
                           const Keyframe& keyframe);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_ISLAND_VIEW_H_
