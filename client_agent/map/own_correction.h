// Says how the robot moved its own map as a whole.
#ifndef CORBSLAM_CLIENT_AGENT_MAP_OWN_CORRECTION_H_
#define CORBSLAM_CLIENT_AGENT_MAP_OWN_CORRECTION_H_

#include <map>

#include "absl/container/btree_set.h"
#include "slam/geometry/rigid3.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

// What moved after a loop was closed, or after everything was adjusted because of one.
struct OwnCorrection {
  struct Motion {
    Rigid3d camera_from_map_before;
    Rigid3d camera_from_map_after;
    // Returns where things beside the keyframe go along with it, in the map's frame.
    Rigid3d AfterFromBefore() const {
      return camera_from_map_after.Inverse() * camera_from_map_before;
    }
  };
  // Own keyframes that moved.
  std::map<KeyframeId, Motion> motions;
  // Others' keyframes, held fixed, that the own map was fitted to.
  absl::btree_set<KeyframeId> fixed;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_MAP_OWN_CORRECTION_H_
