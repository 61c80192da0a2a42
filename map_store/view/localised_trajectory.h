// Computes trajectories of agents that only localised.
#ifndef CORBSLAM_MAP_STORE_VIEW_LOCALISED_TRAJECTORY_H_
#define CORBSLAM_MAP_STORE_VIEW_LOCALISED_TRAJECTORY_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "map_store/state/lookups.h"
#include "map_store/state/mission_state.h"
#include "slam/camera/recorded_camera.h"
#include "slam/geometry/rigid3.h"

namespace corbslam::map_store {

// Returns where the frame's camera stands in the island of its reference keyframe, or of what
// stands for that, as it is placed now. Nullopt: nobody knows the reference any more.
struct PlaceInIsland {
  IslandId island;
  Rigid3d island_from_camera;
};
std::optional<PlaceInIsland> PlaceLocalised(const MissionState& state, const TrackedFrame& frame);

// Appends the poses of the agent's runs, in the order of the runs, each in time. A frame whose
// reference nobody knows, or that lies in another island than the reference one, unless
// `all_islands`, is left out, and marks a gap. Returns FAILED_PRECONDITION, naming the run, if
// nobody said where the wanted frame is.
absl::Status AppendLocalised(const MissionState& state, const AgentState& agent, bool all_islands,
                             PosesOf poses_of, AgentTrajectory& trajectory);
// Appends nothing, and counts what there is.
void LeaveOutLocalised(const AgentState& agent, AgentTrajectory& trajectory);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_LOCALISED_TRAJECTORY_H_
