#include "map_store/fusion/revision_layers.h"

#include <cmath>

#include "absl/container/flat_hash_set.h"
#include "map_store/ingest/local_motion.h"
#include "map_store/view/placement.h"
#include "map_store/view/visible_motion.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Changing so many points in their places takes a millisecond or two.
constexpr size_t kPointsInPlace = 5000;
// A millisecond or two.
constexpr size_t kStepsInAPiece = 4000;

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

void PlaceKeyframe(const PlacedKeyframe& planned, const Camera& camera, PlacedKeyframe& placed) {
  const bool was_shown = placed.moved_by > 0;
  const Similarity3d shown = was_shown ? placed.shown_from_island : placed.camera_from_island;
  const bool stays =
      placed.revision > 0 && !IsSeenToMove(shown, planned.camera_from_island, camera);
  const uint64_t moved_by = stays ? placed.moved_by : planned.revision;
  placed = planned;
  placed.moved_by = moved_by;
  placed.shown_from_island = stays ? shown : planned.camera_from_island;
}

void PlaceKeyframes(const RevisionPlan& plan, const MissionState& state, RevisionLayers& layers) {
  for (const LocalMapId& id : LocalMapsOfSource(plan, state)) {
    for (const LocalMapId& name : state.FindLocalMap(id)->Names()) {
      EraseKeyframesOf(name, layers.keyframes);
    }
  }
  for (const auto& [id, placed] : plan.keyframes) {
    const Keyframe* keyframe = state.FindKeyframe(id);
    if (keyframe != nullptr) PlaceKeyframe(placed, keyframe->camera(), layers.keyframes[id]);
  }
  for (const KeyframeId& id : plan.culled) {
    if (state.FindKeyframe(id) != nullptr) layers.keyframes.erase(id);
  }
}

// Anchors a planned point in a keyframe as the plan places it. Returns nullopt where the point has
// gone, or nothing that is placed sees it.
std::optional<PlacedPoint> AnchorPlanned(MapPointId id, const PlannedPoint& planned,
                                         const MissionState& state, RevisionLayers& layers) {
  const MapPoint* point = state.FindPoint(id);
  if (point == nullptr) return std::nullopt;
  const auto anchor = layers.keyframes.find(planned.anchor);
  if (anchor != layers.keyframes.end()) {
    return PlacedPoint{planned.anchor,
                       anchor->second.camera_from_island * planned.position_in_island,
                       planned.revision};
  }
  layers.chosen.push_back(id);
  return Anchor(*point, planned.position_in_island, planned.revision, state.global,
                layers.keyframes);
}

// Says that a point is still seen where it was `before`, if it is.
void NoteUnseenMotion(const PlacedPoint& before, const MissionState& state, PlacedPoint& placed) {
  if (before.anchor != placed.anchor) return;
  const Keyframe* anchor = state.FindKeyframe(placed.anchor);
  if (anchor == nullptr) return;
  const double unseen =
      before.unseen_motion + (placed.position_in_anchor - before.position_in_anchor).norm();
  if (unseen > LeastVisibleMotion(before.position_in_anchor, anchor->camera())) return;
  placed.revision = before.revision;
  placed.unseen_motion = unseen;
}

// Returns the point's place; one that is seen to stay keeps its revision, as a keyframe keeps the
// one that moved it.
std::optional<PlacedPoint> PlacePoint(MapPointId id, const PlannedPoint& planned,
                                      const MissionState& state, RevisionLayers& layers) {
  std::optional<PlacedPoint> placed = AnchorPlanned(id, planned, state, layers);
  const auto before = state.global.points.find(id);
  if (placed.has_value() && before != state.global.points.end()) {
    NoteUnseenMotion(before->second, state, *placed);
  }
  return placed;
}

absl::Status PlacePoints(const RevisionPlan& plan, const MissionState& state, StepsInPieces& steps,
                         RevisionLayers& layers) {
  layers.changed_points.clear();
  layers.chosen.clear();
  layers.changed_points.reserve(plan.points.size());
  for (const auto& [id, planned] : plan.points) {
    RETURN_IF_ERROR(steps.Advance());
    layers.changed_points.emplace_back(id, PlacePoint(id, planned, state, layers));
  }
  return absl::OkStatus();
}

// Returns all placed points, those that change as they will be.
absl::StatusOr<PlacedPoints> MergePoints(const RevisionLayers& layers, const MissionState& state,
                                         StepsInPieces& steps) {
  const PlacedPoints& placed = state.global.points;
  PlacedPoints merged;
  auto kept = placed.begin();
  auto change = layers.changed_points.begin();
  const auto is_change = [&] {
    return change != layers.changed_points.end() &&
           (kept == placed.end() || change->first <= kept->first);
  };
  while (kept != placed.end() || change != layers.changed_points.end()) {
    const bool changes = is_change();
    const MapPointId id = changes ? change->first : kept->first;
    if (!changes) {
      merged.emplace_hint(merged.end(), id, kept->second);
    } else {
      if (change->second.has_value()) merged.emplace_hint(merged.end(), id, *change->second);
      ++change;
    }
    if (kept != placed.end() && kept->first == id) ++kept;
    const uint64_t version = state.version;
    RETURN_IF_ERROR(steps.Advance());
    // Points may have gone in the pause.
    if (state.version != version) kept = placed.upper_bound(id);
  }
  return merged;
}

// Notes the displaced keyframes of one of the local map's names: what the owner moved while the
// worker was busy counts from here on.
absl::Status NoteMotionSince(const RevisionPlan& plan, double threshold_px, LocalMapId name,
                             const LocalMapState& local_map, StepsInPieces& steps,
                             RevisionLayers& layers) {
  for (auto it = plan.keyframes.lower_bound(KeyframeId{name, 0});
       it != plan.keyframes.end() && it->first.local_map == name; ++it) {
    RETURN_IF_ERROR(steps.Advance());
    const KeyframeId id = it->first;
    if (IsDisplaced(id, threshold_px, local_map, layers.keyframes).value_or(false)) {
      layers.displaced.insert(id);
    } else {
      layers.displaced.erase(id);
    }
  }
  return absl::OkStatus();
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

void RememberTargetFrame(LocalMapId id, const MissionState& state, RevisionLayers& layers) {
  layers.island_from_local.erase(id);
  const auto last = state.global.island_from_local.find(id);
  RememberIslandFrame(*state.FindLocalMap(id),
                      last == state.global.island_from_local.end() ? nullptr : &last->second,
                      layers);
}

// Counts keyframes of the local map that are placed or culled.
size_t CountAdjusted(const RevisionPlan& plan, const LocalMapState& local_map,
                     const MissionState& state, const RevisionLayers& layers) {
  absl::flat_hash_set<KeyframeId> counted;
  for (const LocalMapId& name : local_map.Names()) {
    for (auto it = layers.keyframes.lower_bound(KeyframeId{name, 0});
         it != layers.keyframes.end() && it->first.local_map == name; ++it) {
      counted.insert(it->first);
    }
    for (auto it = state.global.culled.lower_bound(KeyframeId{name, 0});
         it != state.global.culled.end() && it->local_map == name; ++it) {
      counted.insert(*it);
    }
  }
  for (const KeyframeId& id : plan.culled) {
    if (state.OwnerOf(id.local_map) == local_map.id && local_map.map.FindKeyframe(id) != nullptr)
      counted.insert(id);
  }
  return counted.size();
}

// Counts the target's keyframes that the plan, or an earlier one, placed or culled; keyframes that
// came while the worker was busy are neither.
size_t CountAdjusted(const RevisionPlan& plan, const MissionState& state,
                     const RevisionLayers& layers) {
  size_t count = 0;
  for (const LocalMapId& id : state.global.islands.at(plan.target).local_maps) {
    count += CountAdjusted(plan, *state.FindLocalMap(id), state, layers);
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

void RejectPlanned(const RevisionPlan& plan, const MissionState& state,
                   RejectedObservations& rejected) {
  for (const auto& [observation, raw] : plan.rejected_raw) {
    if (state.FindKeyframe(observation.first) != nullptr) rejected[observation] = raw;
  }
}

// An adjustment decides anew about each keyframe that it saw.
void DecideAnew(const RevisionPlan& plan, const MissionState& state, RejectedObservations& rejected,
                RevisionLayers& layers) {
  for (const KeyframeId& id : plan.decided_anew) {
    const RejectedOf before(id, rejected);
    if (!before.empty()) layers.taken_back.push_back(id);
    rejected.erase(before.begin(), before.end());
  }
  RejectPlanned(plan, state, rejected);
}

// Computes what DecideAnew makes of a copy of all that is rejected.
absl::Status CopyDecidedAnew(const RevisionPlan& plan, const MissionState& state,
                             StepsInPieces& steps, RevisionLayers& layers) {
  const RejectedObservations& all = state.global.rejected;
  RejectedObservations& rejected = layers.rejected.emplace();
  for (auto it = all.begin(); it != all.end();) {
    const auto [observation, raw] = *it++;
    if (!plan.decided_anew.contains(observation.first)) {
      rejected.emplace_hint(rejected.end(), observation, raw);
    } else if (layers.taken_back.empty() || layers.taken_back.back() != observation.first) {
      layers.taken_back.push_back(observation.first);
    }
    const uint64_t version = state.version;
    RETURN_IF_ERROR(steps.Advance());
    // A keyframe may have gone in the pause, with all that was rejected of it.
    if (state.version != version) it = all.upper_bound(observation);
  }
  RejectPlanned(plan, state, rejected);
  return absl::OkStatus();
}

// Fills in the rest of `layers`, which has the keyframes as they were.
absl::Status Prepare(const RevisionPlan& plan, const MapStoreOptions& options,
                     const MissionState& state, StepsInPieces& steps, RevisionLayers& layers) {
  PlaceKeyframes(plan, state, layers);
  RETURN_IF_ERROR(PlacePoints(plan, state, steps, layers));
  std::set<LocalMapId> planned;
  for (const auto& [id, keyframe] : plan.keyframes) planned.insert(planned.end(), id.local_map);
  for (const LocalMapId& id : planned) {
    RETURN_IF_ERROR(
        NoteMotionSince(plan, options.local_motion_px, id, *state.FindLocalMap(id), steps, layers));
  }
  for (const LocalMapId& id : state.global.islands.at(plan.target).local_maps) {
    RETURN_IF_ERROR(steps.Advance());
    RememberTargetFrame(id, state, layers);
  }
  for (const LocalMapId& id : LocalMapsOfSource(plan, state)) {
    RememberIslandFrame(*state.FindLocalMap(id), nullptr, layers);
  }
  if (plan.IsAdjustment()) layers.adjusted = CountAdjusted(plan, state, layers);
  return absl::OkStatus();
}

// Collects what owners have changed since layers were prepared.
struct Since {
  absl::flat_hash_set<KeyframeId> gone;
  absl::flat_hash_set<MapPointId> points;  // Points that went, or stand for others.
  std::vector<LocalMapId> local_maps;      // All local maps that changed.
};

std::optional<Since> FindChanges(const MissionState& state, uint64_t version) {
  Since since;
  for (const auto& [id, local_map] : state.local_maps) {
    const std::optional<ItemChanges> changes = local_map.changes.Since(version);
    if (!changes.has_value()) return std::nullopt;
    if (changes->size() > 0) since.local_maps.push_back(id);
    since.points.insert(changes->landmarks.begin(), changes->landmarks.end());
    for (const KeyframeId& keyframe : changes->keyframes) {
      if (local_map.map.FindKeyframe(keyframe) == nullptr) since.gone.insert(keyframe);
    }
  }
  return since;
}

void PlaceAgain(MapPointId id, const RevisionPlan& plan, const MissionState& state,
                RevisionLayers& layers) {
  const auto planned = plan.points.find(id);
  const auto placed = state.global.points.find(id);
  std::optional<PlacedPoint> place;
  if (planned != plan.points.end()) {
    place = PlacePoint(id, planned->second, state, layers);
  } else if (placed != state.global.points.end()) {
    place = placed->second;
  }
  if (place.has_value()) {
    (*layers.points)[id] = *place;
  } else {
    layers.points->erase(id);
  }
}

// Places again the points that changed, those whose anchors have gone, and those whose anchors the
// state had to choose.
void RefreshPoints(const RevisionPlan& plan, const MissionState& state, Since since,
                   RevisionLayers& layers) {
  since.points.insert(layers.chosen.begin(), layers.chosen.end());
  layers.chosen.clear();
  if (!since.gone.empty()) {
    for (const auto& [id, placed] : *layers.points) {
      if (since.gone.contains(placed.anchor)) since.points.insert(id);
    }
  }
  for (const MapPointId& id : since.points) PlaceAgain(id, plan, state, layers);
}

}  // namespace

absl::StatusOr<RevisionLayers> PrepareLayers(const RevisionPlan& plan,
                                             const MapStoreOptions& options,
                                             const MissionState& state, LongRead& read) {
  StepsInPieces steps(read, kStepsInAPiece);
  RevisionLayers layers;
  layers.version = state.version;
  if (plan.IsWelding()) layers.moved = FindMoved(plan, options.loop_residual_px, state);
  layers.keyframes = state.global.keyframes;
  RETURN_IF_ERROR(Prepare(plan, options, state, steps, layers));
  if (layers.changed_points.size() > kPointsInPlace) {
    ASSIGN_OR_RETURN(layers.points, MergePoints(layers, state, steps));
  }
  if (plan.IsAdjustment()) RETURN_IF_ERROR(CopyDecidedAnew(plan, state, steps, layers));
  return layers;
}

RevisionLayers PrepareLayers(const RevisionPlan& plan, const MapStoreOptions& options,
                             const MissionState& state) {
  UnbrokenRead read;
  // A read in one piece has no errors.
  return PrepareLayers(plan, options, state, read).value();
}

RevisionLayers TakeLayers(const RevisionPlan& plan, const MapStoreOptions& options,
                          MissionState& state) {
  UnbrokenRead read;
  StepsInPieces steps(read, kStepsInAPiece);
  RevisionLayers layers;
  if (plan.IsWelding()) layers.moved = FindMoved(plan, options.loop_residual_px, state);
  layers.keyframes = std::move(state.global.keyframes);
  // A read in one piece has no errors.
  Prepare(plan, options, state, steps, layers).IgnoreError();
  if (plan.IsAdjustment()) DecideAnew(plan, state, state.global.rejected, layers);
  return layers;
}

bool RefreshLayers(const RevisionPlan& plan, const MapStoreOptions& options,
                   const MissionState& state, RevisionLayers& layers) {
  if (state.version == layers.version) return true;
  const std::optional<Since> since = FindChanges(state, layers.version);
  if (!since.has_value()) return false;
  for (const KeyframeId& id : since->gone) {
    layers.keyframes.erase(id);
    layers.displaced.erase(id);
    const RejectedOf rejected(id, *layers.rejected);
    layers.rejected->erase(rejected.begin(), rejected.end());
  }
  UnbrokenRead read;
  StepsInPieces steps(read, kStepsInAPiece);
  if (layers.points.has_value()) {
    RefreshPoints(plan, state, *since, layers);
  } else {
    PlacePoints(plan, state, steps, layers).IgnoreError();
  }
  const Island& island = state.global.islands.at(plan.target);
  for (const LocalMapId& id : since->local_maps) {
    if (state.global.island_of.at(id) != island.id) continue;
    const LocalMapState& local_map = *state.FindLocalMap(id);
    for (const LocalMapId& name : local_map.Names()) {
      NoteMotionSince(plan, options.local_motion_px, name, local_map, steps, layers).IgnoreError();
    }
    RememberTargetFrame(id, state, layers);
  }
  if (!since->gone.empty()) layers.adjusted = CountAdjusted(plan, state, layers);
  layers.version = state.version;
  return true;
}

}  // namespace corbslam::map_store
