#include "map_store/ingest/local_motion.h"

#include <optional>

#include "slam/map/scene_depth.h"

namespace corbslam::map_store {
namespace {

// Cameras see nothing as near as this.
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

bool MovesMoreThan(double threshold_px, const Rigid3d& motion, const LocalMapState& local_map,
                   const Keyframe& keyframe) {
  // Nearly all keyframes have not moved at all. That is seen without a depth, which would take a
  // look at every point.
  const double fx_px = keyframe.camera().fx_px;
  if (PixelMotion(motion, kLeastDepth_m, fx_px) <= threshold_px) return false;
  return PixelMotion(motion, MedianDepth(local_map, keyframe), fx_px) > threshold_px;
}

std::optional<bool> IsDisplaced(KeyframeId id, double threshold_px, const LocalMapState& local_map,
                                const PlacedKeyframes& all_placed) {
  const Keyframe* keyframe = local_map.map.FindKeyframe(id);
  const auto placed = all_placed.find(id);
  if (keyframe == nullptr || placed == all_placed.end()) return std::nullopt;
  const Keyframe* parent = local_map.map.FindKeyframe(keyframe->parent);
  const auto placed_parent = all_placed.find(keyframe->parent);
  if (parent == nullptr || placed_parent == all_placed.end()) return std::nullopt;
  const Rigid3d now = keyframe->camera_from_map * parent->camera_from_map.Inverse();
  const Rigid3d then =
      placed->second.camera_from_local * placed_parent->second.camera_from_local.Inverse();
  return MovesMoreThan(threshold_px, now * then.Inverse(), local_map, *keyframe);
}

void NoteLocalMotion(KeyframeId id, double threshold_px, MissionState& state,
                     const LocalMapState& local_map) {
  const std::optional<bool> is_displaced =
      IsDisplaced(id, threshold_px, local_map, state.global.keyframes);
  if (!is_displaced.has_value()) return;
  std::set<KeyframeId>& displaced = state.FindIslandOf(local_map.id)->displaced;
  if (*is_displaced) {
    displaced.insert(id);
  } else {
    displaced.erase(id);
  }
}

}  // namespace corbslam::map_store
