#include "map_store/sharing/share_reach.h"

#include <algorithm>

#include "map_store/sharing/robot_places.h"

namespace corbslam::map_store {

void ShareReach::MoveWithRobot() {
  if (share_.scope.mode != ShareMode::kNearby) return;
  const IslandPoses& own = RobotPlaces(state_, share_, poses_);
  if (own.empty()) return;
  robot_ = CameraCentre(own.rbegin()->second.ToRigid());
  share_.far.MoveTo(*robot_);
  for (const KeyframeId id : share_.far.TakeDue()) share_.news.keyframes.insert(id);
}

bool ShareReach::Wants(KeyframeId id) {
  switch (share_.scope.mode) {
    case ShareMode::kNone:
    case ShareMode::kCorrections:
      return false;
    case ShareMode::kNearby:
      return IsNear(id);
    case ShareMode::kEverything:
      break;
  }
  return true;
}

bool ShareReach::IsNear(KeyframeId id) {
  // Without a robot the keyframe is looked at again each time.
  double out_of_reach_m = 0;
  if (robot_.has_value()) {
    const Similarity3d& pose = poses_.Of(*state_.FindLocalMap(id.local_map)).at(id);
    const double distance_m = (CameraCentre(pose.ToRigid()) - *robot_).norm();
    if (distance_m <= share_.scope.radius_m) {
      share_.far.Erase(id);
      return true;
    }
    out_of_reach_m = distance_m - share_.scope.radius_m;
  }
  share_.far.Add(id, out_of_reach_m);
  return false;
}

}  // namespace corbslam::map_store
