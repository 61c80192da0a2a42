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

// Applies a joining that passed the check. All items keep their ids, and all keyframes their global
// poses. Costs as much as the part has items.
void ApplyJoining(const LocalMapJoining& joining, MissionState& state);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_JOINING_LOCAL_MAP_JOINING_H_
