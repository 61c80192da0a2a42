#include "slam/map/scene_depth.h"

#include <utility>
#include <vector>

#include "slam/util/median.h"

namespace corbslam {

std::optional<double> MedianDepth(const Map& map, const Keyframe& keyframe,
                                  absl::Span<const MapPointId> points) {
  std::vector<double> depths;
  for (const MapPointId& id : points) {
    const MapPoint* point = id.IsValid() ? map.FindPoint(id) : nullptr;
    if (point == nullptr) continue;
    const double depth = (keyframe.camera_from_map * point->position_in_map).z();
    if (depth > 0) depths.push_back(depth);
  }
  if (depths.empty()) return std::nullopt;
  return Median(std::move(depths));
}

std::optional<double> MedianDepth(const Map& map, const Keyframe& keyframe) {
  return MedianDepth(map, keyframe, keyframe.points);
}

}  // namespace corbslam
