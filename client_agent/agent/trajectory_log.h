// Keeps every frame that was tracked, relative to keyframes, so that it follows their corrections.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_TRAJECTORY_LOG_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_TRAJECTORY_LOG_H_

#include <vector>

#include "client_agent/agent/agent.h"
#include "client_agent/map/guarded_map.h"
#include "slam/exchange/map_update.h"

namespace corbslam::client_agent {

// Appends the frames whose reference is of `map`'s local map, by the map as it is now. Frames whose
// reference never came into the map are left out.
void AppendTrajectory(const std::vector<TrackedFrame>& frames, const GuardedMap& map,
                      std::vector<TrajectoryPose>& trajectory);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_TRAJECTORY_LOG_H_
