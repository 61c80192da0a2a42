// Trajectories of every tracked frame, chained through the keyframes' current poses.
#ifndef CORBSLAM_MAP_STORE_VIEW_TRAJECTORY_H_
#define CORBSLAM_MAP_STORE_VIEW_TRAJECTORY_H_

#include <string>

#include "absl/status/statusor.h"
#include "map_store/state/lookups.h"
#include "map_store/state/mission_state.h"
#include "slam/camera/recorded_camera.h"

namespace corbslam::map_store {

// By local map in the order in which the agent opened them, each in time. A frame whose reference
// keyframe was removed follows the relative that its owner named; one whose reference nobody knows
// is left out, and marks a gap. Global: in the frame of the local map's island; only the reference
// island's local maps unless `all_islands`. FAILED_PRECONDITION names the local map whose owner
// never said where the wanted frame is.
absl::StatusOr<AgentTrajectory> ComputeTrajectory(const MissionState& state,
                                                  const std::string& agent, TrajectoryFrame frame,
                                                  bool all_islands, PosesOf poses_of);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_TRAJECTORY_H_
