#include "map_store/sharing/robot_places.h"

namespace corbslam::map_store {
namespace {

// What is near changes by less than what a robot sees from there.
constexpr double kLeastMotion_m = 0.2;
// Keyframes that stand for places that were said.
constexpr KeyframeId kBefore = {LocalMapId{0}, 0};
constexpr KeyframeId kNewest = {LocalMapId{0}, 1};

}  // namespace

bool NoteSaidPlace(const Rigid3d& camera_from_island, ShareState& share) {
  const auto newest = share.said_places.find(kNewest);
  if (newest != share.said_places.end()) {
    const Eigen::Vector3d motion =
        CameraCentre(camera_from_island) - CameraCentre(newest->second.ToRigid());
    if (motion.norm() < kLeastMotion_m) return false;
    share.said_places[kBefore] = newest->second;
  }
  share.said_places[kNewest] = Similarity3d::FromRigid(camera_from_island);
  return true;
}

}  // namespace corbslam::map_store
