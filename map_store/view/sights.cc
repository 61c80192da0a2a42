#include "map_store/view/sights.h"

#include "map_store/view/island_view.h"

namespace corbslam::map_store {

Sights SightsOf(const MissionState& state, const LocalMapState& local_map,
                const Keyframe& keyframe) {
  const std::vector<MapPointId> points = ObservedPoints(state, local_map, keyframe);
  Sights sights;
  for (uint32_t keypoint = 0; keypoint < points.size(); ++keypoint) {
    if (points[keypoint].IsValid()) sights.emplace_back(keypoint, points[keypoint]);
  }
  return sights;
}

}  // namespace corbslam::map_store
