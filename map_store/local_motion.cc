#include "map_store/local_motion.h"

#include <algorithm>
#include <vector>

namespace corbslam::map_store {

double MedianDepth(const LocalMapState& local_map, const Keyframe& keyframe) {
  std::vector<double> depths;
  for (const MapPointId& id : keyframe.points) {
    const MapPoint* point = id.IsValid() ? local_map.map.FindPoint(id) : nullptr;
    if (point == nullptr) continue;
    const double depth = (keyframe.camera_from_map * point->position_in_map).z();
    if (depth > 0) depths.push_back(depth);
  }
  if (depths.empty()) {
    const double close = keyframe.camera().close_depth_m;
    return close > 0 ? close : 1.0;
  }
  const auto middle = depths.begin() + static_cast<ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

double PixelMotion(const Rigid3d& motion, double depth, double fx_px) {
  return fx_px * (RotationAngle(motion.rotation) + motion.translation.norm() / depth);
}

void NoteLocalMotion(KeyframeId id, double threshold_px, MissionState& state,
                     const LocalMapState& local_map) {
  const Keyframe* keyframe = local_map.map.FindKeyframe(id);
  const auto placed = state.global.keyframes.find(id);
  if (keyframe == nullptr || placed == state.global.keyframes.end()) return;
  const Keyframe* parent = local_map.map.FindKeyframe(keyframe->parent);
  const auto placed_parent = state.global.keyframes.find(keyframe->parent);
  if (parent == nullptr || placed_parent == state.global.keyframes.end()) return;
  const Rigid3d now = keyframe->camera_from_map * parent->camera_from_map.Inverse();
  const Rigid3d then =
      placed->second.camera_from_local * placed_parent->second.camera_from_local.Inverse();
  std::set<KeyframeId>& displaced = state.FindIslandOf(local_map.id)->displaced;
  const double motion_px = PixelMotion(now * then.Inverse(), MedianDepth(local_map, *keyframe),
                                       keyframe->camera().fx_px);
  if (motion_px > threshold_px) {
    displaced.insert(id);
  } else {
    displaced.erase(id);
  }
}

}  // namespace corbslam::map_store
