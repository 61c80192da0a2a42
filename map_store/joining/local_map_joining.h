// Makes one local map of two that are closed and that fusion has joined
// (docs/adr/0036-sessions-become-one.md).
#ifndef CORBSLAM_MAP_STORE_JOINING_LOCAL_MAP_JOINING_H_
#define CORBSLAM_MAP_STORE_JOINING_LOCAL_MAP_JOINING_H_

#include "absl/status/status.h"
#include "map_store/state/mission_state.h"
#include "slam/geometry/rigid3.h"

namespace corbslam::map_store {

// Is a value, and what the journal keeps.
struct LocalMapJoining {
  LocalMapId part;  // Becomes a part of `whole`, an earlier local map of the same agent.
  LocalMapId whole;
  Rigid3d whole_from_part;  // Between the frames of the two local maps.
};

// Returns FAILED_PRECONDITION, saying what stands against it: the two are not closed, of one agent,
// of one island and of the same cameras, in this order of arrival. That holds for records, too.
absl::Status CheckJoining(const LocalMapJoining& joining, const MissionState& state);
// Returns FAILED_PRECONDITION where it should not be done now: something is still to come or to be
// fused, somebody keeps one of them apart from others, or poses of keyframes would not be what they
// are. What it looks at need not be the same in a replay.
absl::Status CheckMayJoin(const LocalMapJoining& joining, const MissionState& state);

// These are what that asks of one local map. Whether the cameras are the same; whether somebody
// keeps it apart from others; what stands against it as a part, of any whole.
bool HaveSameCameras(const LocalMapState& a, const LocalMapState& b);
bool IsKeptApart(const LocalMapState& local_map, const GlobalLayer& global);
absl::Status MayBecomePart(const LocalMapState& local_map, const MissionState& state);
// Returns whether each keyframe has its global pose by itself or through its own tree. What follows
// a neighbour in the order of ids would follow another one in a larger local map. Walks all trees.
bool StandsByItself(const LocalMapState& local_map, const GlobalLayer& global);

// Applies a joining that passed the check. All items keep their ids, and all keyframes their global
// poses. Costs as much as the part has items.
void ApplyJoining(const LocalMapJoining& joining, MissionState& state);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_JOINING_LOCAL_MAP_JOINING_H_
