// Says where the robot is that is told something.
#ifndef CORBSLAM_MAP_STORE_SHARING_ROBOT_PLACES_H_
#define CORBSLAM_MAP_STORE_SHARING_ROBOT_PLACES_H_

#include "map_store/state/mission_state.h"
#include "map_store/state/share_state.h"
#include "map_store/view/placement.h"

namespace corbslam::map_store {

// Returns the places of the robot's keyframes in its island's frame, the newest last; of a robot
// that localises only, where it said that it was. The result is good as long as `poses` and `share`
// stay as they are.
inline const IslandPoses& RobotPlaces(const MissionState& state, const ShareState& share,
                                      PoseCache& poses) {
  if (!share.local_map.IsValid()) return share.said_places;
  return poses.Of(*state.FindLocalMap(share.local_map));
}

// Notes where a robot that localises only was, in the island's frame. Returns false if it has
// hardly moved since it said so last.
bool NoteSaidPlace(const Rigid3d& camera_from_island, ShareState& share);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_SHARING_ROBOT_PLACES_H_
