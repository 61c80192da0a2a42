#include "client_agent/far/far_share.h"

#include <utility>

namespace corbslam::client_agent {
namespace {

SharedMapPoint Describe(const MapPoint& point) {
  SharedMapPoint shared;
  shared.id = point.id;
  shared.position_in_global = point.position_in_map;
  shared.reference = point.reference;
  shared.descriptor = point.descriptor;
  shared.normal_in_global = point.normal_in_map;
  shared.min_distance = point.min_distance;
  shared.max_distance = point.max_distance;
  return shared;
}

}  // namespace

void FarShare::Restart() {
  told_place_ = false;
  told_.clear();
  viewers_.clear();
}

SharedUpdate FarShare::BeginUpdate() {
  SharedUpdate update;
  update.revision = ++updates_;
  update.apart = true;
  if (!std::exchange(told_place_, true)) update.global_from_local = Similarity3d::Identity();
  return update;
}

SharedUpdate FarShare::Bring(const Map& local_map, std::span<const KeyframeId> ids) {
  SharedUpdate update = BeginUpdate();
  for (const KeyframeId id : ids) {
    const Keyframe* keyframe = local_map.FindKeyframe(id);
    if (keyframe == nullptr || told_.contains(id)) continue;
    SharedKeyframe shared;
    shared.payload = keyframe->payload;
    shared.camera_from_global = Similarity3d::FromRigid(keyframe->camera_from_map);
    shared.parent = keyframe->parent;
    shared.points = keyframe->points;
    std::vector<MapPointId>& seen = told_[id];
    for (MapPointId& seen_id : shared.points) {
      const MapPoint* point = seen_id.IsValid() ? local_map.FindPoint(seen_id) : nullptr;
      if (point == nullptr) {
        seen_id = MapPointId();
        continue;
      }
      seen.push_back(seen_id);
      if (viewers_[seen_id]++ == 0) update.points.push_back(Describe(*point));
    }
    update.keyframes.push_back(std::move(shared));
  }
  return update;
}

SharedUpdate FarShare::TakeOut(std::span<const KeyframeId> ids) {
  SharedUpdate update = BeginUpdate();
  for (const KeyframeId id : ids) {
    const auto told = told_.find(id);
    if (told == told_.end()) continue;
    update.removed_keyframes.push_back(id);
    for (const MapPointId point : told->second) {
      const auto viewers = viewers_.find(point);
      if (--viewers->second > 0) continue;
      update.removed_points.push_back(point);
      viewers_.erase(viewers);
    }
    told_.erase(told);
  }
  return update;
}

}  // namespace corbslam::client_agent
