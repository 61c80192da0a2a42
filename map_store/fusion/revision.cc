#include "map_store/fusion/revision.h"

#include <algorithm>
#include <set>
#include <utility>

#include "absl/container/flat_hash_set.h"
#include "map_store/ingest/anchoring.h"
#include "map_store/ingest/change_recording.h"

namespace corbslam::map_store {
namespace {

void ChangePoints(const RevisionLayers& layers, PlacedPoints& points) {
  for (const auto& [id, placed] : layers.changed_points) {
    if (placed.has_value()) {
      points[id] = *placed;
    } else {
      points.erase(id);
    }
  }
}

void MergeIslands(const RevisionPlan& plan, MissionState& state) {
  Island& target = state.global.islands.at(plan.target);
  const auto it = state.global.islands.find(plan.source);
  if (it == state.global.islands.end()) return;
  Island source = std::move(it->second);
  state.global.islands.erase(it);
  target.relaxed.merge(source.relaxed);
  target.version_of_owners = std::max(target.version_of_owners, source.version_of_owners);
  std::set<LocalMapId> members(target.local_maps.begin(), target.local_maps.end());
  members.insert(source.local_maps.begin(), source.local_maps.end());
  target.local_maps.clear();
  for (const LocalMapId& id : state.order) {
    if (!members.contains(id)) continue;
    target.local_maps.push_back(id);
    // Foreign points are not seen until now, as they lay in another island.
    LocalMapState& local_map = *state.FindLocalMap(id);
    for (const auto& [keyframe, seen] : local_map.foreign_observations) {
      local_map.changes.NoteSights(keyframe);
    }
  }
  for (const LocalMapId& id : source.local_maps) {
    SetIslandOf(*state.FindLocalMap(id), plan.target, state);
  }
}

void RejectObservations(const RevisionPlan& plan, RevisionLayers& layers, MissionState& state) {
  const auto note = [&state](KeyframeId id) {
    if (LocalMapState* owner = state.FindLocalMap(id.local_map)) owner->changes.NoteSights(id);
  };
  for (const KeyframeId& id : layers.taken_back) note(id);
  for (const auto& [observation, raw] : plan.rejected_raw) note(observation.first);
  if (layers.rejected.has_value()) {
    std::swap(state.global.rejected, *layers.rejected);
    return;
  }
  for (const auto& [observation, raw] : plan.rejected_raw) {
    if (state.FindKeyframe(observation.first) != nullptr) state.global.rejected[observation] = raw;
  }
}

void CullKeyframes(const RevisionPlan& plan, MissionState& state) {
  for (const KeyframeId& id : plan.culled) {
    LocalMapState* owner = state.FindLocalMap(id.local_map);
    if (owner == nullptr || owner->map.FindKeyframe(id) == nullptr) continue;
    state.global.culled.insert(id);
    owner->changes.NoteKeyframe(id);
  }
}

void MergeLandmarks(const RevisionPlan& plan, MissionState& state) {
  GlobalLayer& global = state.global;
  absl::flat_hash_set<MapPointId> renamed;
  for (const FuseMapsResult::Merge& merge : plan.merges) {
    renamed.insert({merge.survivor, merge.member});
  }
  NoteLandmarkChanges(renamed, state);
  for (const FuseMapsResult::Merge& merge : plan.merges) {
    const MapPointId survivor = ResolvePoint(state, merge.survivor);
    const MapPointId member = ResolvePoint(state, merge.member);
    if (!survivor.IsValid() || !member.IsValid() || survivor == member) continue;
    const bool here = global.island_of.at(survivor.local_map) == plan.target &&
                      global.island_of.at(member.local_map) == plan.target;
    if (!here) continue;
    global.landmarks.Merge(survivor, member);
    HandOverPlace(member, survivor, state);
  }
}

}  // namespace

void CommitRevision(const RevisionPlan& plan, RevisionLayers& layers, MissionState& state) {
  state.global.revision = plan.revision;
  MergeIslands(plan, state);
  std::swap(state.global.keyframes, layers.keyframes);
  if (layers.points.has_value()) {
    std::swap(state.global.points, *layers.points);
  } else {
    ChangePoints(layers, state.global.points);
  }
  RejectObservations(plan, layers, state);
  CullKeyframes(plan, state);
  MergeLandmarks(plan, state);
  Island& island = state.global.islands.at(plan.target);
  island.fused = true;
  if (plan.IsWelding()) {
    island.moved.merge(layers.moved);
    island.moved.insert(island.displaced.begin(), island.displaced.end());
  }
  island.displaced = std::move(layers.displaced);
  for (const LocalMapId& id : island.local_maps) {
    const auto frame = layers.island_from_local.find(id);
    if (frame != layers.island_from_local.end()) {
      state.global.island_from_local[id] = frame->second;
    } else {
      state.global.island_from_local.erase(id);
    }
  }
  for (const uint64_t id : plan.overlaps) {
    state.global.overlaps.Change(id, [&plan](OverlapEntry& entry) {
      entry.state = OverlapState::kInGraph;
      entry.revision = plan.revision;
      entry.note.clear();
    });
  }
  TouchByFusion(state, plan.target);
}

}  // namespace corbslam::map_store
