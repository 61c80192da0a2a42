#include "map_store/change_recording.h"

namespace corbslam::map_store {
namespace {

// Keyframes of the point's own local map that see it.
void NoteOwnSightings(MapPointId id, MissionState& state) {
  LocalMapState* owner = state.FindLocalMap(id.local_map);
  if (owner == nullptr) return;
  owner->changes.NoteLandmark(id);
  const MapPoint* point = owner->map.FindPoint(id);
  if (point == nullptr) return;
  for (const auto& [keyframe, keypoint] : point->observations) owner->changes.NoteSights(keyframe);
}

void NoteForeignSightings(const absl::flat_hash_set<MapPointId>& landmarks, MissionState& state) {
  for (auto& [id, local_map] : state.local_maps) {
    for (const auto& [keyframe, seen] : local_map.foreign_observations) {
      for (const auto& [keypoint, raw] : seen) {
        if (!landmarks.contains(ResolvePoint(state, raw))) continue;
        local_map.changes.NoteSights(keyframe);
        break;
      }
    }
  }
}

}  // namespace

void NoteLandmarkChanges(const absl::flat_hash_set<MapPointId>& points, MissionState& state) {
  if (points.empty()) return;
  absl::flat_hash_set<MapPointId> landmarks;
  for (const MapPointId& id : points) {
    NoteOwnSightings(id, state);
    if (const MapPointId landmark = ResolvePoint(state, id); landmark.IsValid()) {
      landmarks.insert(landmark);
    }
  }
  const Landmarks::Sets& sets = state.global.landmarks.sets();
  for (const MapPointId& landmark : landmarks) {
    NoteOwnSightings(landmark, state);
    const auto it = sets.find(landmark);
    if (it == sets.end()) continue;
    for (const MapPointId& member : it->second) NoteOwnSightings(member, state);
  }
  NoteForeignSightings(landmarks, state);
}

}  // namespace corbslam::map_store
