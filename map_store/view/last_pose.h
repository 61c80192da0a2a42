// Finds where an agent was last.
#ifndef CORBSLAM_MAP_STORE_VIEW_LAST_POSE_H_
#define CORBSLAM_MAP_STORE_VIEW_LAST_POSE_H_

#include <optional>

#include "map_store/state/lookups.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Returns the newest frame with a pose of the agent's newest session that has one, in the frame of
// its local map's island; nullopt as long as there is none. Of an agent that localises only it is
// what that said, of no local map. Where no one knows the keyframe that the frame refers to, or it
// lies in another island, the frame that came before it stands for it. Which session is the newest
// goes by their arrival, also of those that have become parts of others: a robot's clock may begin
// anew with each start. It looks at all its sessions and a few frames, however many there are; the
// poses of keyframes are those that were found already (FindPoses).
std::optional<LastPose> FindLastPose(const MissionState& state, const AgentState& agent);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_LAST_POSE_H_
