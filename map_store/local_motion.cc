#include "map_store/local_motion.h"

#include <optional>

#include "slam/map/scene_depth.h"

namespace corbslam::map_store {

double MedianDepth(const LocalMapState& local_map, const Keyframe& keyframe) {
  const std::optional<double> depth = corbslam::MedianDepth(local_map.map, keyframe);
  if (depth.has_value()) return *depth;
  const double close = keyframe.camera().close_depth_m;
  return close > 0 ? close : 1.0;
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
