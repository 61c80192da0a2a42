// Says which of the keyframes that an agent lacks it wants to be told of (ShareScope).
#ifndef CORBSLAM_MAP_STORE_SHARING_SHARE_REACH_H_
#define CORBSLAM_MAP_STORE_SHARING_SHARE_REACH_H_

#include <Eigen/Core>
#include <optional>

#include "map_store/state/mission_state.h"
#include "map_store/state/share_state.h"
#include "map_store/view/placement.h"

namespace corbslam::map_store {

// Not thread-safe.
class ShareReach {
 public:
  // None of the arguments is copied.
  ShareReach(const MissionState& state, PoseCache& poses, ShareState& share)
      : state_(state), poses_(poses), share_(share) {}

  // Looks where the robot is, and adds to `share.news` the far keyframes that it may have come
  // near.
  void MoveWithRobot();
  // Returns whether the agent wants to be told of another's living keyframe. One that is too far
  // away is kept in `share.far`, and is no news until MoveWithRobot says so.
  bool Wants(KeyframeId id);

 private:
  bool IsNear(KeyframeId id);

  const MissionState& state_;
  PoseCache& poses_;
  ShareState& share_;
  // The robot's newest place, in the island's frame; none: it has none.
  std::optional<Eigen::Vector3d> robot_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_SHARING_SHARE_REACH_H_
