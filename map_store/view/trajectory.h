// Computes trajectories of every tracked frame, chained through the keyframes' current poses.
#ifndef CORBSLAM_MAP_STORE_VIEW_TRAJECTORY_H_
#define CORBSLAM_MAP_STORE_VIEW_TRAJECTORY_H_

#include <string>

#include "absl/status/statusor.h"
#include "map_store/state/lookups.h"
#include "map_store/state/mission_state.h"
#include "slam/camera/recorded_camera.h"

namespace corbslam::map_store {

// Returns an agent's poses by local map in the order in which the agent opened them, each in time.
// A frame whose reference keyframe was removed follows the relative that its owner named; one whose
// reference nobody knows is left out, and marks a gap. Global poses are in the frame of the local
// map's island; they are of the reference island's local maps only, unless `all_islands`. What an
// agent localised in others' local maps follows (AppendLocalised); it has global poses alone.
// Returns FAILED_PRECONDITION, naming the local map, if its owner never said where the wanted frame
// is.
absl::StatusOr<AgentTrajectory> ComputeTrajectory(const MissionState& state,
                                                  const std::string& agent, TrajectoryFrame frame,
                                                  bool all_islands, PosesOf poses_of);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_TRAJECTORY_H_
