#include "map_store/ingest/change_recording.h"

#include <vector>

namespace corbslam::map_store {
namespace {

// Notes the point, and the keyframes of its own local map that see it.
void NoteOwnSightings(MapPointId id, MissionState& state) {
  LocalMapState* owner = state.FindLocalMap(id.local_map);
  if (owner == nullptr) return;
  owner->changes.NoteLandmark(id);
  const MapPoint* point = owner->map.FindPoint(id);
  if (point == nullptr) return;
  for (const auto& [keyframe, keypoint] : point->observations) owner->changes.NoteSights(keyframe);
}

// Notes the keyframes of other local maps that see a member of the landmark, by any name that the
// member ever had.
void NoteForeignSightings(MapPointId member, MapPointId landmark, MissionState& state) {
  for (const MapPointId& name : state.points.NamesOf(member)) {
    const std::vector<KeyframeId> viewers = state.points.ViewersOf(name);
    // A name that was taken apart from the member since may stand for another landmark now.
    if (viewers.empty() || ResolvePoint(state, name) != landmark) continue;
    for (const KeyframeId& viewer : viewers) {
      state.FindLocalMap(viewer.local_map)->changes.NoteSights(viewer);
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
    NoteForeignSightings(landmark, landmark, state);
    const auto it = sets.find(landmark);
    if (it == sets.end()) continue;
    for (const MapPointId& member : it->second) {
      NoteOwnSightings(member, state);
      NoteForeignSightings(member, landmark, state);
    }
  }
}

}  // namespace corbslam::map_store
