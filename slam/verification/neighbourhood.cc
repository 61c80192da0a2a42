#include "slam/verification/neighbourhood.h"

#include <algorithm>
#include <utility>

namespace corbslam {

std::vector<const Keyframe*> Neighbourhood(const Map& map, KeyframeId centre, int count,
                                           const absl::btree_set<KeyframeId>& except) {
  std::vector<const Keyframe*> keyframes;
  const Keyframe* first = map.FindKeyframe(centre);
  if (first == nullptr) return keyframes;
  keyframes.push_back(first);
  for (const CovisibleKeyframe& covisible : map.Covisible(centre, 1)) {
    if (keyframes.size() > static_cast<size_t>(std::max(count, 0))) break;
    if (except.contains(covisible.id)) continue;
    if (const Keyframe* keyframe = map.FindKeyframe(covisible.id)) keyframes.push_back(keyframe);
  }
  return keyframes;
}

std::vector<const MapPoint*> PointsSeenBy(const Map& map,
                                          const std::vector<const Keyframe*>& keyframes) {
  std::vector<MapPointId> ids;
  for (const Keyframe* keyframe : keyframes) {
    for (const MapPointId& id : keyframe->points) {
      if (id.IsValid()) ids.push_back(id);
    }
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  std::vector<const MapPoint*> points;
  points.reserve(ids.size());
  for (const MapPointId& id : ids) {
    if (const MapPoint* point = map.FindPoint(id)) points.push_back(point);
  }
  return points;
}

Map ViewAround(const Map& map, KeyframeId centre, int count) {
  Map view;
  const std::vector<const Keyframe*> keyframes = Neighbourhood(map, centre, count);
  for (const Keyframe* original : keyframes) {
    Keyframe keyframe;
    keyframe.payload = original->payload;
    keyframe.words = original->words;
    keyframe.camera_from_map = original->camera_from_map;
    view.AddKeyframe(std::move(keyframe));
  }
  for (const Keyframe* keyframe : keyframes) view.SetParent(keyframe->id(), keyframe->parent);
  for (const MapPoint* point : PointsSeenBy(map, keyframes)) {
    view.AddPoint(*point);
    for (const auto& [keyframe, keypoint] : point->observations) {
      view.AddObservation(point->id, keyframe, keypoint);
    }
  }
  return view;
}

}  // namespace corbslam
