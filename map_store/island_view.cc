#include "map_store/island_view.h"

#include <utility>

namespace corbslam::map_store {
namespace {

// Builds a Map of an island's keyframes and what they see.
class ViewBuilder {
 public:
  ViewBuilder(const MissionState& state, const Island& island, const Unplaced& unplaced,
              Rejected rejected)
      : state_(state), unplaced_(unplaced), rejected_(rejected) {
    for (const LocalMapId& id : island.local_maps) {
      poses_[id] = ComputePoses(*state.FindLocalMap(id), state.global, unplaced);
    }
  }

  void AddKeyframe(const LocalMapState& local_map, const Keyframe& from) {
    Keyframe keyframe;
    keyframe.payload = from.payload;
    keyframe.words = from.words;
    keyframe.camera_from_map = poses_.at(local_map.id).at(from.id()).ToRigid();
    view_.AddKeyframe(std::move(keyframe));
  }

  // Once all keyframes are there.
  void Connect() {
    const std::vector<KeyframeId> ids = KeyframeIds();
    for (const KeyframeId& id : ids) {
      const LocalMapState& local_map = *state_.FindLocalMap(id.local_map);
      const Keyframe& from = *local_map.map.FindKeyframe(id);
      view_.SetParent(id, from.parent);
      for (const KeyframeId& other : from.loop_edges) view_.AddLoopEdge(id, other);
      AddObservations(local_map, from);
    }
    for (const auto& [id, poses] : poses_) {
      for (const LoopEdge& edge : state_.FindLocalMap(id)->foreign_loop_edges) {
        view_.AddLoopEdge(edge.a, edge.b);
      }
    }
  }

  Map TakeView() { return std::move(view_); }
  const IslandPoses& poses(LocalMapId id) const { return poses_.at(id); }

 private:
  std::vector<KeyframeId> KeyframeIds() const {
    std::vector<KeyframeId> ids;
    ids.reserve(view_.keyframes().size());
    for (const auto& [id, keyframe] : view_.keyframes()) ids.push_back(id);
    return ids;
  }

  void AddObservations(const LocalMapState& local_map, const Keyframe& from) {
    const std::vector<MapPointId> points = ObservedPoints(state_, local_map, from, rejected_);
    for (uint32_t keypoint = 0; keypoint < points.size(); ++keypoint) {
      const MapPointId id = points[keypoint];
      if (!id.IsValid()) continue;
      if (view_.FindPoint(id) == nullptr) AddPoint(id);
      view_.AddObservation(id, from.id(), keypoint);
    }
  }

  void AddPoint(MapPointId id) {
    const LocalMapState& owner = *state_.FindLocalMap(id.local_map);
    MapPoint point = *owner.map.FindPoint(id);
    const IslandPoses& poses = poses_.at(owner.id);
    const Similarity3d island_from_local =
        IslandFromLocal(point.reference, owner, state_.global, poses);
    point.position_in_map = ComputePosition(point, owner, state_.global, poses, unplaced_);
    point.normal_in_map = island_from_local.rotation * point.normal_in_map;
    point.min_distance *= island_from_local.scale;
    point.max_distance *= island_from_local.scale;
    view_.AddPoint(std::move(point));
  }

  const MissionState& state_;
  const Unplaced& unplaced_;
  const Rejected rejected_;
  std::map<LocalMapId, IslandPoses> poses_;
  Map view_;
};

}  // namespace

std::vector<MapPointId> ObservedPoints(const MissionState& state, const LocalMapState& local_map,
                                       const Keyframe& keyframe, Rejected treatment) {
  const IslandId island = state.global.island_of.at(local_map.id);
  // What the local map's own graph holds is alive: only fusion can have given it another name.
  std::vector<MapPointId> points = keyframe.points;
  for (MapPointId& point : points) {
    if (point.IsValid()) point = state.global.landmarks.Survivor(point);
  }
  const auto foreign = local_map.foreign_observations.find(keyframe.id());
  if (foreign != local_map.foreign_observations.end()) {
    for (const auto& [keypoint, raw] : foreign->second) {
      const MapPointId point = ResolvePoint(state, raw);
      const bool here = point.IsValid() && state.global.island_of.at(point.local_map) == island;
      points[keypoint] = here ? point : MapPointId();
    }
  }
  if (treatment == Rejected::kTryAgain) return points;
  const RejectedObservations& rejected = state.global.rejected;
  for (auto it = rejected.lower_bound({keyframe.id(), 0});
       it != rejected.end() && it->first.first == keyframe.id(); ++it) {
    const uint32_t keypoint = it->first.second;
    if (RawObservation(local_map, keyframe.id(), keypoint) == it->second) {
      points[keypoint] = MapPointId();
    }
  }
  return points;
}

IslandSnapshot TakeIslandSnapshot(const MissionState& state, const Island& island,
                                  const Unplaced& unplaced, Rejected rejected) {
  IslandSnapshot snapshot;
  snapshot.island = island.id;
  snapshot.revision = state.global.revision;
  snapshot.generation = island.generation;
  snapshot.version_of_owners = island.version_of_owners;
  ViewBuilder builder(state, island, unplaced, rejected);
  for (const LocalMapId& id : island.local_maps) {
    const LocalMapState& local_map = *state.FindLocalMap(id);
    snapshot.poses.insert(builder.poses(id).begin(), builder.poses(id).end());
    for (const auto& [keyframe_id, keyframe] : local_map.map.keyframes()) {
      builder.AddKeyframe(local_map, keyframe);
      snapshot.local_poses[keyframe_id] = keyframe.camera_from_map;
    }
  }
  builder.Connect();
  snapshot.view = builder.TakeView();
  return snapshot;
}

Map BuildPartialView(const MissionState& state, const Island& island,
                     const std::set<KeyframeId>& keyframes) {
  const Unplaced none;
  ViewBuilder builder(state, island, none, Rejected::kLeaveOut);
  for (const KeyframeId& id : keyframes) {
    const LocalMapState* local_map = state.FindLocalMap(id.local_map);
    const Keyframe* keyframe = local_map == nullptr ? nullptr : local_map->map.FindKeyframe(id);
    if (keyframe != nullptr) builder.AddKeyframe(*local_map, *keyframe);
  }
  builder.Connect();
  return builder.TakeView();
}

int CountSharedLandmarks(const MissionState& state, KeyframeId a, KeyframeId b) {
  const Keyframe* first = state.FindKeyframe(a);
  const Keyframe* second = state.FindKeyframe(b);
  if (first == nullptr || second == nullptr) return 0;
  if (state.global.island_of.at(a.local_map) != state.global.island_of.at(b.local_map)) return 0;
  std::set<MapPointId> seen;
  for (const MapPointId& id : ObservedPoints(state, *state.FindLocalMap(a.local_map), *first)) {
    if (id.IsValid()) seen.insert(id);
  }
  int shared = 0;
  for (const MapPointId& id : ObservedPoints(state, *state.FindLocalMap(b.local_map), *second)) {
    if (id.IsValid() && seen.contains(id)) ++shared;
  }
  return shared;
}

}  // namespace corbslam::map_store
