#include "map_store/retiring/other_visits.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "slam/util/median.h"

namespace corbslam::map_store {
namespace {

struct Stand {
  KeyframeId id;
  Eigen::Vector3d center;  // In the island's frame.
  Eigen::Vector3d axis;
};

Stand StandOf(const Keyframe& keyframe) {
  const Rigid3d map_from_camera = keyframe.camera_from_map.Inverse();
  return {keyframe.id(), map_from_camera.translation,
          map_from_camera.rotation * Eigen::Vector3d::UnitZ()};
}

std::optional<double> MedianDistance(const Map& map, const Keyframe& keyframe,
                                     size_t min_landmarks) {
  std::vector<double> distances;
  for (const MapPointId& id : keyframe.points) {
    const MapPoint* point = id.IsValid() ? map.FindPoint(id) : nullptr;
    if (point == nullptr) continue;
    distances.push_back((keyframe.camera_from_map * point->position_in_map).norm());
  }
  if (distances.size() < std::max<size_t>(min_landmarks, 1)) return std::nullopt;
  return Median(std::move(distances));
}

}  // namespace

OtherVisits FindOtherVisits(const RetiringView& view, const OtherVisitsOptions& options) {
  std::vector<Stand> stands;
  for (const auto& [id, keyframe] : view.map.keyframes()) {
    if (view.closed.contains(id.local_map)) stands.push_back(StandOf(keyframe));
  }
  OtherVisits other_visits;
  for (const KeyframeId& id : view.candidates) {
    const Keyframe* keyframe = view.map.FindKeyframe(id);
    if (keyframe == nullptr) continue;
    const auto distance = MedianDistance(view.map, *keyframe, options.min_landmarks);
    if (!distance.has_value()) continue;
    const Stand here = StandOf(*keyframe);
    for (const Stand& other : stands) {
      if (other.id.local_map == id.local_map) continue;
      const bool is_near = (other.center - here.center).norm() <= options.near_share * *distance;
      if (!is_near || other.axis.dot(here.axis) < options.min_axis_cosine) continue;
      other_visits[id].push_back(other.id);
    }
  }
  return other_visits;
}

}  // namespace corbslam::map_store
