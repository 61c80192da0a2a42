#include "client_agent/mapping/keyframe_insertion.h"

#include <utility>

#include "client_agent/mapping/nearest_keypoints.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kMinPointsFromDepth = 100;

struct Resolved {
  Rigid3d camera_from_map;
  KeyframeId parent;
  std::vector<MapPointId> points;
};

Resolved Resolve(const NewKeyframe& keyframe, const GuardedMap& guarded) {
  return guarded.ReadWithHistory([&](const Map& map, const MapHistory& history) {
    Resolved resolved;
    resolved.camera_from_map = keyframe.camera_from_reference;
    if (const auto reference = history.CameraFromMap(map, keyframe.reference)) {
      resolved.camera_from_map = keyframe.camera_from_reference * *reference;
    }
    resolved.parent = keyframe.reference;
    for (const MapPointId id : keyframe.points) {
      resolved.points.push_back(id.IsValid() ? history.CurrentPoint(id) : id);
    }
    return resolved;
  });
}

// A removed reference hands its place to the parent that it hung on, else to the newest keyframe.
KeyframeId ChooseParent(const Map& map, LocalMapId own, KeyframeId wanted) {
  if (map.FindKeyframe(wanted) != nullptr) return wanted;
  KeyframeId newest;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (id.local_map == own) newest = id;
  }
  return newest;
}

MapPointId AddPointFromDepth(const Keyframe& keyframe, uint32_t keypoint_index, MapPointId id,
                             Map& map) {
  const Keypoint& keypoint = keyframe.keypoints()[keypoint_index];
  const double depth_m = DepthFromDisparity(keyframe.camera(), keypoint.disparity_px);
  MapPoint point;
  point.id = id;
  point.reference = keyframe.id();
  point.position_in_map = keyframe.camera_from_map.Inverse() *
                          Unproject(keyframe.camera(), keypoint.x_px, keypoint.y_px, depth_m);
  point.descriptor = keyframe.descriptors()[keypoint_index];
  map.AddPoint(std::move(point));
  map.AddObservation(id, keyframe.id(), keypoint_index);
  map.UpdatePointGeometry(id);
  return id;
}

void ChooseBestParent(const KeyframeId id, LocalMapId own, Map& map) {
  for (const CovisibleKeyframe& relative : map.BestCovisible(id, 5)) {
    if (relative.id.local_map != own) continue;
    map.SetParent(id, relative.id);
    return;
  }
}

void AddFirst(const MapBeginning& beginning, Map& map) {
  Keyframe first;
  first.payload = beginning.first;
  first.words = beginning.words;
  map.AddKeyframe(std::move(first));
}

void AddFoundPoints(const MapBeginning& beginning, KeyframeId second, GuardedMap& guarded,
                    Map& map) {
  const KeyframeId first = beginning.first->id;
  for (const FoundPoint& found : beginning.points) {
    MapPoint point;
    point.id = guarded.NewPointId();
    point.position_in_map = found.position_in_map;
    point.reference = second;
    const MapPointId id = point.id;
    map.AddPoint(std::move(point));
    map.AddObservation(id, first, found.in_first);
    map.AddObservation(id, second, found.in_second);
    map.UpdatePointAppearance(id);
  }
}

}  // namespace

std::vector<MapPointId> InsertKeyframe(const NewKeyframe& fresh, GuardedMap& guarded) {
  const Resolved resolved = Resolve(fresh, guarded);
  const KeyframeId id = fresh.payload->id;
  Keyframe keyframe;
  keyframe.payload = fresh.payload;
  keyframe.words = fresh.words;
  keyframe.camera_from_map = resolved.camera_from_map;
  return guarded.Write([&](Map& map) {
    if (fresh.beginning != nullptr) AddFirst(*fresh.beginning, map);
    keyframe.parent = ChooseParent(map, id.local_map, resolved.parent);
    map.AddKeyframe(std::move(keyframe));
    if (fresh.beginning != nullptr) AddFoundPoints(*fresh.beginning, id, guarded, map);
    for (size_t i = 0; i < resolved.points.size(); ++i) {
      if (!map.AddObservation(resolved.points[i], id, static_cast<uint32_t>(i))) continue;
      if (resolved.points[i].local_map == id.local_map) {
        map.UpdatePointAppearance(resolved.points[i]);
      }
    }
    ChooseBestParent(id, id.local_map, map);
    std::vector<MapPointId> made;
    const Keyframe& inserted = *map.FindKeyframe(id);
    for (const uint32_t i :
         NearestKeypoints(inserted.camera(), inserted.keypoints(), kMinPointsFromDepth)) {
      if (inserted.points[i].IsValid()) continue;
      made.push_back(AddPointFromDepth(inserted, i, guarded.NewPointId(), map));
    }
    return made;
  });
}

int CountObservations(const Map& map, const MapPoint& point) {
  int count = 0;
  for (const auto& [id, keypoint] : point.observations) {
    count += map.FindKeyframe(id)->keypoints()[keypoint].HasDepth() ? 2 : 1;
  }
  return count;
}

}  // namespace corbslam::client_agent
