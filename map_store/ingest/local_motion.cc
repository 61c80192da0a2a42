#include "map_store/ingest/local_motion.h"

#include <optional>

#include "slam/map/scene_depth.h"

namespace corbslam::map_store {
namespace {

// Nearer than anything that a camera sees.
constexpr double kLeastDepth_m = 1e-3;

}  // namespace

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
  // Nearly all have not moved at all, which no depth is needed to see: that looks at every point.
  const Rigid3d motion = now * then.Inverse();
  const double fx_px = keyframe->camera().fx_px;
  const bool may_matter = PixelMotion(motion, kLeastDepth_m, fx_px) > threshold_px;
  if (may_matter && PixelMotion(motion, MedianDepth(local_map, *keyframe), fx_px) > threshold_px) {
    displaced.insert(id);
  } else {
    displaced.erase(id);
  }
}

}  // namespace corbslam::map_store
