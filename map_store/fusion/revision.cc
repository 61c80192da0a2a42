#include "map_store/fusion/revision.h"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "map_store/ingest/anchoring.h"
#include "map_store/ingest/change_recording.h"
#include "map_store/ingest/local_motion.h"
#include "map_store/view/placement.h"

namespace corbslam::map_store {
namespace {

using NewPoses = std::map<KeyframeId, Similarity3d>;

NewPoses Index(const std::vector<KeyframePose>& poses) {
  NewPoses indexed;
  for (const KeyframePose& pose : poses) indexed[pose.id] = pose.camera_from_map;
  return indexed;
}

// Puts the scale back: the worker saw cameras whose units were rescaled to the view's.
Similarity3d Rescale(const Similarity3d& pose, double scale) {
  return {pose.scale * scale, pose.rotation, pose.translation * scale};
}

void PlanKeyframes(const MissionState& state, const IslandSnapshot& snapshot,
                   const NewPoses& new_poses, const Similarity3d& snapshot_from_target,
                   RevisionPlan& plan) {
  for (const auto& [id, pose] : snapshot.poses) {
    const LocalMapState& local_map = *state.FindLocalMap(id.local_map);
    if (!local_map.IsSettled(id) || local_map.map.FindKeyframe(id) == nullptr) continue;
    if (state.global.culled.contains(id)) continue;
    const auto moved = new_poses.find(id);
    const Similarity3d placed =
        moved == new_poses.end() ? pose * snapshot_from_target : Rescale(moved->second, pose.scale);
    plan.keyframes[id] = {placed, snapshot.local_poses.at(id), plan.revision};
  }
}

// Returns whether the point gets a position of its own: only survivors whose reference keyframe is
// placed do.
bool IsPlaceable(const MissionState& state, MapPointId id, const RevisionPlan& plan) {
  const MapPoint* own = state.FindPoint(id);
  return own != nullptr && plan.keyframes.contains(ReferenceOf(*own, state.global)) &&
         state.global.landmarks.Survivor(id) == id;
}

void PlanPositions(const MissionState& state, const std::vector<PointPosition>& positions,
                   RevisionPlan& plan) {
  for (const auto& [id, position] : positions) {
    if (IsPlaceable(state, id, plan)) plan.points[id] = {position, plan.revision};
  }
}

// Plans also the points that the adjustment left alone: they move with their reference keyframes.
void PlanPointsOfView(const MissionState& state, const IslandSnapshot& snapshot, const Map& view,
                      RevisionPlan& plan) {
  absl::flat_hash_map<KeyframeId, Similarity3d> motions;
  for (const auto& [id, point] : view.points()) {
    if (plan.points.contains(id) || !IsPlaceable(state, id, plan)) continue;
    const KeyframeId reference = ReferenceOf(*state.FindPoint(id), state.global);
    const auto [it, added] = motions.try_emplace(reference);
    if (added) {
      it->second =
          plan.keyframes.at(reference).camera_from_island.Inverse() * snapshot.poses.at(reference);
    }
    plan.points[id] = {it->second * point.position_in_map, plan.revision};
  }
}

// Points that are anchored in a keyframe move with it. Those whose keyframe is derived anew from
// its owner's poses are derived anew, too.
void PlanDerivedPoints(const MissionState& state, const IslandSnapshot& snapshot,
                       RevisionPlan& plan) {
  std::set<LocalMapId> derived;
  for (const KeyframeId& id : snapshot.unplaced) derived.insert(id.local_map);
  for (const LocalMapId& local_map : derived) {
    const Map& map = state.FindLocalMap(local_map)->map;
    for (auto it = state.global.points.lower_bound(MapPointId{local_map, 0});
         it != state.global.points.end() && it->first.local_map == local_map; ++it) {
      const MapPoint* point = map.FindPoint(it->first);
      if (point == nullptr) continue;
      const KeyframeId reference = ReferenceOf(*point, state.global);
      const auto planned = plan.keyframes.find(reference);
      if (planned == plan.keyframes.end() || !snapshot.unplaced.contains(reference)) continue;
      const Similarity3d local = Similarity3d::FromRigid(planned->second.camera_from_local);
      const Similarity3d island_from_local = planned->second.camera_from_island.Inverse() * local;
      plan.points[it->first] = {island_from_local * point->position_in_map, plan.revision};
    }
  }
}

// Points that were merged into each survivor, in the order of merging.
using MergedPoints = absl::flat_hash_map<MapPointId, std::vector<MapPointId>>;

MergedPoints GroupBySurvivor(const std::vector<FuseMapsResult::Merge>& merges) {
  MergedPoints members;
  for (const FuseMapsResult::Merge& merge : merges) {
    members[merge.survivor].push_back(merge.member);
  }
  return members;
}

// Returns the keypoint by which the keyframe saw the point, or a point that was merged into it, in
// the views.
std::optional<uint32_t> FindKeypoint(const std::vector<const Map*>& views,
                                     const MergedPoints& merged,
                                     const RejectedObservation& rejected) {
  std::vector<MapPointId> names = {rejected.point};
  if (const auto it = merged.find(rejected.point); it != merged.end()) {
    names.insert(names.end(), it->second.begin(), it->second.end());
  }
  for (const Map* view : views) {
    for (const MapPointId& name : names) {
      const MapPoint* point = view->FindPoint(name);
      if (point == nullptr) continue;
      const auto it = point->observations.find(rejected.keyframe);
      if (it != point->observations.end()) return it->second;
    }
  }
  return std::nullopt;
}

void PlanRejected(const MissionState& state, const std::vector<const Map*>& views,
                  const std::vector<RejectedObservation>& rejected, RevisionPlan& plan) {
  const MergedPoints merged = GroupBySurvivor(plan.merges);
  for (const RejectedObservation& observation : rejected) {
    const LocalMapState* local_map = state.FindLocalMap(observation.keyframe.local_map);
    if (local_map == nullptr) continue;
    const std::optional<uint32_t> keypoint = FindKeypoint(views, merged, observation);
    if (!keypoint.has_value()) continue;
    const MapPointId raw = RawObservation(*local_map, observation.keyframe, *keypoint);
    if (!raw.IsValid()) continue;
    plan.rejected_raw[{observation.keyframe, *keypoint}] = raw;
  }
}

// Returns the local maps of the source island; none where the plan moves no island.
std::vector<LocalMapId> LocalMapsOfSource(const RevisionPlan& plan, const MissionState& state) {
  const auto source = state.global.islands.find(plan.source);
  if (source == state.global.islands.end()) return {};
  return source->second.local_maps;
}

// Erases what an adjustment placed in the source's own frame after the snapshot was taken. Points
// that are anchored in them are not placed then.
void EraseKeyframesOf(LocalMapId local_map, PlacedKeyframes& keyframes) {
  const auto begin = keyframes.lower_bound(KeyframeId{local_map, 0});
  auto end = begin;
  while (end != keyframes.end() && end->first.local_map == local_map) ++end;
  keyframes.erase(begin, end);
}

void PlaceKeyframes(const RevisionPlan& plan, const MissionState& state, RevisionLayers& layers) {
  for (const LocalMapId& id : LocalMapsOfSource(plan, state)) {
    EraseKeyframesOf(id, layers.keyframes);
  }
  for (const auto& [id, placed] : plan.keyframes) layers.keyframes[id] = placed;
  for (const KeyframeId& id : plan.culled) {
    if (state.FindKeyframe(id) != nullptr) layers.keyframes.erase(id);
  }
}

// Anchors the plan's points in the keyframes as the plan places them.
void PlacePoints(const RevisionPlan& plan, const MissionState& state, RevisionLayers& layers) {
  for (const auto& [id, planned] : plan.points) {
    const MapPoint* point = state.FindPoint(id);
    std::optional<PlacedPoint> placed;
    if (point != nullptr) {
      placed = Anchor(*point, planned.position_in_island, planned.revision, state.global,
                      layers.keyframes);
    }
    layers.changed_points.emplace_back(id, placed);
  }
}

void ChangePoints(const RevisionLayers& layers, PlacedPoints& points) {
  for (const auto& [id, placed] : layers.changed_points) {
    if (placed.has_value()) {
      points[id] = *placed;
    } else {
      points.erase(id);
    }
  }
}

// Returns the displaced keyframes: what owners moved while the worker was busy counts from here on.
std::set<KeyframeId> FindMotionSince(const RevisionPlan& plan, double threshold_px,
                                     const MissionState& state, const RevisionLayers& layers) {
  std::set<KeyframeId> displaced;
  for (const auto& [id, placed] : plan.keyframes) {
    const LocalMapState& local_map = *state.FindLocalMap(id.local_map);
    const bool is_displaced =
        IsDisplaced(id, threshold_px, local_map, layers.keyframes).value_or(false);
    if (is_displaced) displaced.insert(displaced.end(), id);
  }
  return displaced;
}

void RememberIslandFrame(const LocalMapState& local_map, const Similarity3d* last,
                         RevisionLayers& layers) {
  const IslandPoses poses = ComputePoses(local_map, layers.keyframes, last);
  if (!poses.empty()) {
    layers.island_from_local[local_map.id] = IslandFromLocal(local_map, poses);
  } else if (last != nullptr) {
    layers.island_from_local[local_map.id] = *last;
  }
}

void RememberIslandFrames(const RevisionPlan& plan, const MissionState& state,
                          RevisionLayers& layers) {
  for (const LocalMapId& id : state.global.islands.at(plan.target).local_maps) {
    const auto last = state.global.island_from_local.find(id);
    RememberIslandFrame(*state.FindLocalMap(id),
                        last == state.global.island_from_local.end() ? nullptr : &last->second,
                        layers);
  }
  for (const LocalMapId& id : LocalMapsOfSource(plan, state)) {
    RememberIslandFrame(*state.FindLocalMap(id), nullptr, layers);
  }
}

// Counts the target's keyframes that the plan, or an earlier one, placed or culled; keyframes that
// came while the worker was busy are neither.
size_t CountAdjusted(const RevisionPlan& plan, const MissionState& state,
                     const RevisionLayers& layers) {
  const std::set<KeyframeId> culled(plan.culled.begin(), plan.culled.end());
  size_t count = 0;
  for (const LocalMapId& local_map : state.global.islands.at(plan.target).local_maps) {
    for (const auto& [id, keyframe] : state.FindLocalMap(local_map)->map.keyframes()) {
      count +=
          layers.keyframes.contains(id) || culled.contains(id) || state.global.culled.contains(id);
    }
  }
  return count;
}

// Returns keyframes that the plan puts by more than `threshold_px` elsewhere than they stood.
std::set<KeyframeId> FindMoved(const RevisionPlan& plan, double threshold_px,
                               const MissionState& state) {
  std::set<KeyframeId> moved;
  for (const auto& [id, planned] : plan.keyframes) {
    const auto placed = state.global.keyframes.find(id);
    const Keyframe* keyframe = state.FindKeyframe(id);
    if (placed == state.global.keyframes.end() || keyframe == nullptr) continue;
    const Similarity3d motion =
        planned.camera_from_island * placed->second.camera_from_island.Inverse();
    if (MovesMoreThan(threshold_px, motion.ToRigid(), *state.FindLocalMap(id.local_map),
                      *keyframe)) {
      moved.insert(id);
    }
  }
  return moved;
}

// An adjustment decides anew about each keyframe that it saw.
void DecideAnew(const RevisionPlan& plan, RejectedObservations& rejected, RevisionLayers& layers) {
  for (const KeyframeId& id : plan.decided_anew) {
    const RejectedOf before(id, rejected);
    if (!before.empty()) layers.taken_back.push_back(id);
    rejected.erase(before.begin(), before.end());
  }
  for (const auto& [observation, raw] : plan.rejected_raw) rejected[observation] = raw;
}

// Fills in the rest of `layers`, which has the keyframes as they were.
void Prepare(const RevisionPlan& plan, const MapStoreOptions& options, const MissionState& state,
             RevisionLayers& layers) {
  PlaceKeyframes(plan, state, layers);
  PlacePoints(plan, state, layers);
  layers.displaced = FindMotionSince(plan, options.local_motion_px, state, layers);
  RememberIslandFrames(plan, state, layers);
  if (plan.IsAdjustment()) layers.adjusted = CountAdjusted(plan, state, layers);
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
  for (const LocalMapId& id : source.local_maps) state.global.island_of[id] = plan.target;
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
    state.global.rejected[observation] = raw;
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

RevisionPlan PlanFuse(const MissionState& state, const FuseJob& job, const FuseMapsResult& result) {
  RevisionPlan plan;
  plan.revision = state.global.revision + 1;
  plan.target = job.action.target;
  plan.source = job.action.source;
  plan.merges = result.merges;
  plan.overlaps = job.new_overlaps;
  const NewPoses poses = Index(result.poses);
  PlanKeyframes(state, job.target, poses, Similarity3d(), plan);
  std::vector<const Map*> views = {&job.request.target};
  if (job.source.has_value()) {
    PlanKeyframes(state, *job.source, poses, result.target_from_source.Inverse(), plan);
    PlanDerivedPoints(state, *job.source, plan);
    views.push_back(&job.request.source);
  }
  PlanDerivedPoints(state, job.target, plan);
  PlanPositions(state, result.positions, plan);
  PlanRejected(state, views, result.rejected, plan);
  return plan;
}

RevisionPlan PlanAdjust(const MissionState& state, const AdjustJob& job,
                        const AdjustBundleResult& result) {
  RevisionPlan plan;
  plan.revision = state.global.revision + 1;
  plan.target = job.snapshot.island;
  for (const KeyframeId& id : result.redundant) {
    if (job.snapshot.poses.contains(id)) plan.culled.push_back(id);
  }
  PlanKeyframes(state, job.snapshot, Index(result.poses), Similarity3d(), plan);
  PlanPositions(state, result.positions, plan);
  PlanPointsOfView(state, job.snapshot, job.request.view, plan);
  PlanRejected(state, {&job.request.view}, result.rejected, plan);
  for (const auto& [id, keyframe] : job.request.view.keyframes()) plan.decided_anew.insert(id);
  return plan;
}

RevisionLayers PrepareLayers(const RevisionPlan& plan, const MapStoreOptions& options,
                             const MissionState& state) {
  // Changing so many points takes a millisecond or two.
  constexpr size_t kPointsInPlace = 5000;
  RevisionLayers layers;
  if (plan.IsWelding()) layers.moved = FindMoved(plan, options.loop_residual_px, state);
  layers.keyframes = state.global.keyframes;
  Prepare(plan, options, state, layers);
  if (layers.changed_points.size() > kPointsInPlace) {
    layers.points = state.global.points;
    ChangePoints(layers, *layers.points);
  }
  if (plan.IsAdjustment()) {
    layers.rejected = state.global.rejected;
    DecideAnew(plan, *layers.rejected, layers);
  }
  return layers;
}

RevisionLayers TakeLayers(const RevisionPlan& plan, const MapStoreOptions& options,
                          MissionState& state) {
  RevisionLayers layers;
  if (plan.IsWelding()) layers.moved = FindMoved(plan, options.loop_residual_px, state);
  layers.keyframes = std::move(state.global.keyframes);
  Prepare(plan, options, state, layers);
  if (plan.IsAdjustment()) DecideAnew(plan, state.global.rejected, layers);
  return layers;
}

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
