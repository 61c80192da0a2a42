#include "map_store/ingest/graph_changes.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_set.h"
#include "map_store/ingest/anchoring.h"

namespace corbslam::map_store {
namespace {

void RemoveForeignObservation(KeyframeId keyframe, uint32_t keypoint, MissionState& state,
                              LocalMapState& local_map) {
  const auto it = local_map.foreign_observations.find(keyframe);
  if (it == local_map.foreign_observations.end()) return;
  local_map.changes.NoteSights(keyframe);
  const auto seen = it->second.find(keypoint);
  if (seen == it->second.end()) return;
  state.points.RemoveViewer(seen->second, keyframe, keypoint);
  it->second.erase(seen);
  if (it->second.empty()) local_map.foreign_observations.erase(it);
}

void ForgetForeignObservations(KeyframeId keyframe, MissionState& state, LocalMapState& local_map) {
  const auto it = local_map.foreign_observations.find(keyframe);
  if (it == local_map.foreign_observations.end()) return;
  for (const auto& [keypoint, point] : it->second) {
    state.points.RemoveViewer(point, keyframe, keypoint);
  }
  local_map.foreign_observations.erase(it);
}

void ClearKeypoint(KeyframeId keyframe, uint32_t keypoint, MissionState& state,
                   LocalMapState& local_map) {
  const MapPointId own = local_map.map.FindKeyframe(keyframe)->points[keypoint];
  if (own.IsValid()) local_map.map.RemoveObservation(own, keyframe);
  RemoveForeignObservation(keyframe, keypoint, state, local_map);
}

void ObserveForeign(KeyframeId keyframe, uint32_t keypoint, MapPointId point, MissionState& state,
                    LocalMapState& local_map) {
  if (const auto old = state.points.FindSight(point, keyframe)) {
    RemoveForeignObservation(keyframe, *old, state, local_map);
  }
  ClearKeypoint(keyframe, keypoint, state, local_map);
  local_map.foreign_observations[keyframe][keypoint] = point;
  state.points.AddViewer(point, keyframe, keypoint);
  local_map.changes.NoteSights(keyframe);
}

// Returns what the owner's own point became through the owner's own replacements: another own
// point, or somebody else's. Shortens the chain, so that the next caller finds its end in a step.
MapPointId FollowReplacements(LocalMapState& local_map, MapPointId point) {
  auto& replaced = local_map.replaced_points;
  MapPointId last = point;
  size_t steps = 0;
  for (auto it = replaced.find(last); it != replaced.end(); it = replaced.find(last)) {
    last = it->second;
    // Only a chain that was restored from elsewhere can lead in a circle.
    if (++steps > replaced.size()) return MapPointId();
  }
  while (point != last) point = std::exchange(replaced.at(point), last);
  return last;
}

// Returns whether what the owners replaced, one after the other, leads from `point` to `goal`.
bool LeadsTo(const MissionState& state, MapPointId point, MapPointId goal) {
  constexpr int kMaxSteps = 1000;
  for (int step = 0; step < kMaxSteps && point != goal; ++step) {
    const LocalMapState* owner = state.FindLocalMap(point.local_map);
    if (owner == nullptr) return false;
    const auto next = owner->replaced_points.find(point);
    if (next == owner->replaced_points.end()) return false;
    point = next->second;
  }
  return true;
}

void RemoveObservation(const ObservationChange& change, MissionState& state,
                       LocalMapState& local_map) {
  const MapPointId point = FollowReplacements(local_map, change.point);
  if (local_map.map.RemoveObservation(point, change.keyframe)) return;
  if (const auto keypoint = state.points.FindSight(point, change.keyframe)) {
    RemoveForeignObservation(change.keyframe, *keypoint, state, local_map);
  }
}

// Returns the keyframe, its children, their children, and so on.
absl::flat_hash_set<KeyframeId> FindFamily(const Map& map, const Keyframe& keyframe) {
  absl::flat_hash_set<KeyframeId> family = {keyframe.id()};
  std::vector<KeyframeId> open = {keyframe.id()};
  while (!open.empty()) {
    const Keyframe& next = *map.FindKeyframe(open.back());
    open.pop_back();
    for (const KeyframeId& child : next.children) {
      if (family.insert(child).second) open.push_back(child);
    }
  }
  return family;
}

// Hangs the child on the last keyframe that came before it and that does not hang on it. A local
// map's tree is its own, so that this takes the place of a parent in another local map.
void HangOnOneBefore(const Keyframe& child, LocalMapState& local_map) {
  const absl::flat_hash_set<KeyframeId> family = FindFamily(local_map.map, child);
  for (size_t before = local_map.arrival.at(child.id()); before > 0; --before) {
    const KeyframeId& id = local_map.arrived[before - 1];
    if (!family.contains(id) && local_map.map.SetParent(child.id(), id)) return;
  }
}

}  // namespace

std::optional<MissingItem> ApplyObservation(const ObservationChange& change, MissionState& state,
                                            LocalMapState& local_map) {
  if (local_map.removed_keyframes.contains(change.keyframe)) return std::nullopt;
  const Keyframe* keyframe = local_map.map.FindKeyframe(change.keyframe);
  if (keyframe == nullptr) return change.keyframe;
  if (change.kind == ObservationChange::Kind::kRemoved) {
    RemoveObservation(change, state, local_map);
    return std::nullopt;
  }
  if (change.keypoint >= keyframe->points.size()) return std::nullopt;
  MapPointId point = change.point;
  const MapPoint* own = local_map.map.FindPoint(point);
  // A point that is in the map was neither replaced nor removed.
  if (own == nullptr) {
    point = FollowReplacements(local_map, change.point);
    if (!point.IsValid() || local_map.removed_points.contains(point)) return std::nullopt;
    if (!local_map.IsNamed(point.local_map)) {
      ObserveForeign(change.keyframe, change.keypoint, point, state, local_map);
      return std::nullopt;
    }
    own = local_map.map.FindPoint(point);
    if (own == nullptr) return point;
  }
  if (keyframe->points[change.keypoint] == point) return std::nullopt;
  ClearKeypoint(change.keyframe, change.keypoint, state, local_map);
  if (own->observations.contains(change.keyframe)) {
    local_map.map.RemoveObservation(point, change.keyframe);
  }
  local_map.map.AddObservation(point, change.keyframe, change.keypoint);
  return std::nullopt;
}

std::optional<MissingItem> ApplyParent(KeyframeId child_id, KeyframeId parent,
                                       LocalMapState& local_map) {
  const Keyframe* child = local_map.map.FindKeyframe(child_id);
  if (child == nullptr || !parent.IsValid()) return std::nullopt;
  if (!local_map.IsNamed(parent.local_map)) {
    HangOnOneBefore(*child, local_map);
    return std::nullopt;
  }
  // A removed parent's children hang where it hung; the steps up are limited.
  constexpr int kMaxSteps = 1000;
  int step = 0;
  for (auto it = local_map.removed_keyframes.find(parent); it != local_map.removed_keyframes.end();
       it = local_map.removed_keyframes.find(parent)) {
    if (++step > kMaxSteps) return std::nullopt;
    parent = it->second.parent;
  }
  if (!parent.IsValid()) return std::nullopt;
  if (local_map.map.FindKeyframe(parent) == nullptr) return parent;
  local_map.map.SetParent(child_id, parent);
  return std::nullopt;
}

std::optional<MissingItem> ApplyLoopEdge(const LoopEdge& edge, MissionState& state,
                                         LocalMapState& local_map) {
  if (local_map.removed_keyframes.contains(edge.a)) return std::nullopt;
  if (!local_map.IsNamed(edge.b.local_map)) {
    local_map.foreign_loop_edges.push_back(edge);
  } else {
    if (local_map.removed_keyframes.contains(edge.b)) return std::nullopt;
    for (const KeyframeId& end : {edge.a, edge.b}) {
      if (local_map.map.FindKeyframe(end) == nullptr) return end;
    }
    if (!local_map.map.AddLoopEdge(edge.a, edge.b)) return std::nullopt;
  }
  Island& island = *state.FindIslandOf(local_map.id);
  if (island.fused) island.relaxed.insert(local_map.id);
  return std::nullopt;
}

void ApplyReplacement(const PointReplacement& replacement, MissionState& state,
                      LocalMapState& local_map) {
  const MapPointId replaced = replacement.replaced;
  if (local_map.replaced_points.contains(replaced) || local_map.removed_points.contains(replaced)) {
    return;
  }
  const MapPointId survivor = FollowReplacements(local_map, replacement.survivor);
  if (survivor == replaced || !survivor.IsValid()) return;
  const bool is_own = local_map.IsNamed(survivor.local_map);
  // Two robots may each have put the other's point in the place of its own: then the point stays,
  // and stands for both. What fusion merged does not change what an owner says of its own points.
  const MapPointId stands_for = ResolvePoint(state, survivor);
  if (!is_own && (stands_for == replaced || LeadsTo(state, survivor, replaced))) return;
  if (is_own) {
    if (!local_map.map.ReplacePoint(replaced, survivor)) local_map.map.RemovePoint(replaced);
  } else if (const MapPoint* point = local_map.map.FindPoint(replaced)) {
    const auto observations = point->observations;
    local_map.map.RemovePoint(replaced);
    for (const auto& [keyframe, keypoint] : observations) {
      if (state.points.FindSight(survivor, keyframe).has_value()) continue;
      ObserveForeign(keyframe, keypoint, survivor, state, local_map);
    }
  }
  local_map.replaced_points[replaced] = survivor;
  local_map.parked.Release(replaced);
  state.points.NoteReplaced(replaced, survivor);
  // A landmark lies in one island, and so do all its points.
  const bool joins =
      stands_for.IsValid() && stands_for != replaced &&
      state.global.island_of.at(stands_for.local_map) == state.global.island_of.at(local_map.id);
  const MapPointId elected = joins ? state.global.landmarks.Replace(replaced, stands_for)
                                   : state.global.landmarks.Remove(replaced);
  HandOverPlace(replaced, elected, state);
}

void ApplyPointRemoval(MapPointId point, MissionState& state, LocalMapState& local_map) {
  if (local_map.replaced_points.contains(point)) return;
  if (point.local_map == local_map.id) {
    if (!local_map.removed_points.insert(point).second) return;
  } else if (local_map.map.FindPoint(point) == nullptr) {
    return;
  }
  local_map.map.RemovePoint(point);
  local_map.parked.Release(point);
  const MapPointId elected = state.global.landmarks.Remove(point);
  HandOverPlace(point, elected, state);
  // Other local maps' keyframes that saw this very point still see the landmark.
  if (!elected.IsValid()) return;
  state.global.heirs[point] = elected;
  state.points.NoteReplaced(point, elected);
}

void ApplyKeyframeRemoval(const KeyframeRemoval& removal, MissionState& state,
                          LocalMapState& local_map) {
  const bool is_new =
      local_map.removed_keyframes
          .try_emplace(removal.id, Tombstone{removal.parent, removal.parent_from_removed})
          .second;
  if (!is_new) return;
  local_map.parked.Release(removal.id);
  local_map.parked_parents.Release(removal.id);
  local_map.parked_parents.Erase(removal.id);
  local_map.database.Remove(removal.id);
  const std::vector<LostPlace> lost = TakePlaces(removal.id, state.global, local_map);
  local_map.map.RemoveKeyframe(removal.id);
  local_map.followers.Forget(removal.id);
  ForgetForeignObservations(removal.id, state, local_map);
  state.global.keyframes.erase(removal.id);
  AnchorElsewhere(lost, state);
  state.global.culled.erase(removal.id);
  const RejectedOf rejected(removal.id, state.global.rejected);
  state.global.rejected.erase(rejected.begin(), rejected.end());
  state.FindIslandOf(local_map.id)->displaced.erase(removal.id);
}

}  // namespace corbslam::map_store
