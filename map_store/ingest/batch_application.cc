#include "map_store/ingest/batch_application.h"

#include <algorithm>
#include <set>
#include <utility>

#include "map_store/ingest/change_recording.h"
#include "map_store/ingest/graph_changes.h"
#include "map_store/ingest/local_motion.h"
#include "map_store/ingest/parked_references.h"
#include "map_store/ingest/quota.h"
#include "map_store/ingest/settling.h"

namespace corbslam::map_store {
namespace {

Rigid3d Normalised(const Rigid3d& pose) { return {pose.rotation.normalized(), pose.translation}; }

void AddCameras(const MapUpdateBatch& batch, LocalMapState& local_map) {
  for (size_t i = 0; i < batch.cameras.size(); ++i) {
    if (batch.first_camera_index + i < local_map.cameras.size()) continue;
    local_map.cameras.push_back(batch.cameras[i]);
    local_map.recorded_cameras.resize(local_map.cameras.size());
    if (batch.recorded_cameras.empty()) continue;
    local_map.recorded_cameras.back() = batch.recorded_cameras[i];
  }
}

bool IsKnown(KeyframeId id, const LocalMapState& local_map) {
  return local_map.arrival.contains(id) || local_map.removed_keyframes.contains(id);
}

void AddKeyframe(const FullKeyframe& full, const BatchWords& words, LocalMapState& local_map) {
  const KeyframeId id = full.payload->id;
  if (IsKnown(id, local_map)) return;
  Keyframe keyframe;
  keyframe.payload = full.payload;
  // Batches from the wire may come without a camera; the keyframe gets the store's own then.
  if (keyframe.payload->camera == nullptr) {
    keyframe.payload = WithCamera(*full.payload, local_map.cameras[full.payload->camera_index]);
  }
  keyframe.camera_from_map = Normalised(full.camera_from_local);
  if (const auto it = words.find(id); it != words.end()) keyframe.words = it->second;
  if (keyframe.words != nullptr) local_map.database.Add(id, keyframe.words);
  local_map.map.AddKeyframe(std::move(keyframe));
  local_map.parked.Release(id);
  local_map.parked_parents.Release(id);
  local_map.arrival[id] = local_map.arrived.size();
  local_map.arrived.push_back(id);
}

void AddPoint(const FullMapPoint& full, LocalMapState& local_map) {
  if (local_map.removed_points.contains(full.id) || local_map.replaced_points.contains(full.id)) {
    return;
  }
  MapPoint point;
  point.id = full.id;
  point.position_in_map = full.position_in_local;
  point.reference = full.reference;
  point.descriptor = full.descriptor;
  point.normal_in_map = full.normal_in_local;
  point.min_distance = full.min_distance;
  point.max_distance = full.max_distance;
  if (!local_map.map.AddPoint(std::move(point))) return;
  local_map.parked.Release(full.id);
  local_map.followers.Add(full.reference, full.id);
  local_map.changes.NotePoint(full.id);
}

void AddFullItems(const MapUpdateBatch& batch, const BatchWords& words, MissionState& state,
                  LocalMapState& local_map) {
  AddCameras(batch, local_map);
  std::set<KeyframeId> added;
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    const bool known = local_map.arrival.contains(keyframe.payload->id);
    AddKeyframe(keyframe, words, local_map);
    if (!known) added.insert(keyframe.payload->id);
  }
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    if (!added.contains(keyframe.payload->id)) continue;
    TakeParent(keyframe.payload->id, keyframe.parent, local_map);
  }
  for (const FullMapPoint& point : batch.full_points) AddPoint(point, local_map);
  if (!batch.full_keyframes.empty() || !batch.full_points.empty()) RetryParked(state, local_map);
}

// Moves the points that follow the keyframe, so that they keep their place in its camera.
void MoveFollowers(KeyframeId id, const Rigid3d& local_from_before, LocalMapState& local_map) {
  const auto follows = [&](MapPointId point) { return local_map.map.FindPoint(point) != nullptr; };
  for (const MapPointId point : local_map.followers.Of(id, follows)) {
    local_map.map.SetPosition(point,
                              local_from_before * local_map.map.FindPoint(point)->position_in_map);
  }
}

void MoveLightItems(const MapUpdateBatch& batch, LocalMapState& local_map) {
  for (const LightKeyframe& light : batch.light_keyframes) {
    const Keyframe* keyframe = local_map.map.FindKeyframe(light.id);
    if (keyframe == nullptr) continue;
    const Rigid3d before = keyframe->camera_from_map;
    const Rigid3d now = Normalised(light.camera_from_local);
    local_map.map.SetPose(light.id, now);
    if (batch.points_follow) MoveFollowers(light.id, now.Inverse() * before, local_map);
    TakeParent(light.id, light.parent, local_map);
  }
  for (const LightMapPoint& light : batch.light_points) {
    local_map.map.SetPosition(light.id, light.position_in_local);
  }
}

// Returns the points whose landmarks the batch may change.
absl::flat_hash_set<MapPointId> FindRenamed(const MapUpdateBatch& batch) {
  absl::flat_hash_set<MapPointId> points(batch.removed_points.begin(), batch.removed_points.end());
  for (const PointReplacement& replacement : batch.replacements) {
    points.insert({replacement.replaced, replacement.survivor});
  }
  return points;
}

void ChangeGraph(const MapUpdateBatch& batch, MissionState& state, LocalMapState& local_map) {
  NoteLandmarkChanges(FindRenamed(batch), state);
  for (const PointReplacement& replacement : batch.replacements) {
    ApplyReplacement(replacement, state, local_map);
  }
  for (const ObservationChange& change : batch.observations) {
    TakeReference({change}, state, local_map);
  }
  for (const MapPointId& point : batch.removed_points) {
    ApplyPointRemoval(point, state, local_map);
  }
  for (const KeyframeRemoval& removal : batch.removed_keyframes) {
    ApplyKeyframeRemoval(removal, state, local_map);
  }
  for (const LoopEdge& edge : batch.loop_edges) {
    TakeReference({edge}, state, local_map);
  }
}

// Notes new keyframes, and those that they make old enough to be told of. Returns false if there
// are none.
bool NoteShareable(size_t share_after, size_t arrived_before, LocalMapState& local_map) {
  const size_t arrived = local_map.arrived.size();
  if (arrived == arrived_before && !local_map.closed) return false;
  const size_t first = arrived_before - std::min(arrived_before, share_after);
  for (size_t i = first; i < arrived; ++i) local_map.changes.NoteKeyframe(local_map.arrived[i]);
  return true;
}

}  // namespace

std::shared_ptr<const MapUpdateBatch> WithoutKnownKeyframes(const MapUpdateBatch& batch,
                                                            const LocalMapState* local_map) {
  const auto is_known = [local_map](const FullKeyframe& keyframe) {
    return local_map != nullptr && IsKnown(keyframe.payload->id, *local_map);
  };
  if (std::ranges::none_of(batch.full_keyframes, is_known)) {
    return {std::shared_ptr<void>(), &batch};
  }
  auto news = std::make_shared<MapUpdateBatch>(batch);
  std::erase_if(news->full_keyframes, is_known);
  return news;
}

void ApplyBatch(const MapUpdateBatch& batch, const BatchWords& words,
                const MapStoreOptions& options, MissionState& state, LocalMapState& local_map) {
  const ChangeRecorder recorder(local_map);
  const size_t arrived_before = local_map.arrived.size();
  AddFullItems(batch, words, state, local_map);
  MoveLightItems(batch, local_map);
  ChangeGraph(batch, state, local_map);
  const size_t tracked_before = local_map.frames.size();
  const size_t lost_before = local_map.lost_frames_ns.size();
  local_map.frames.insert(local_map.frames.end(), batch.tracked_frames.begin(),
                          batch.tracked_frames.end());
  local_map.lost_frames_ns.insert(local_map.lost_frames_ns.end(), batch.lost_frames_ns.begin(),
                                  batch.lost_frames_ns.end());
  NoteNewestFrames(tracked_before, lost_before, local_map);
  local_map.closed = local_map.closed || batch.closes_local_map;
  local_map.last_batch = batch.number;
  local_map.stored_bytes += StoredBytes(batch);
  for (const LightKeyframe& light : batch.light_keyframes) {
    NoteLocalMotion(light.id, options.local_motion_px, state, local_map);
  }
  SettleKeyframes(options.settle_after, state, local_map);
  const bool share = NoteShareable(options.share_after, arrived_before, local_map) ||
                     !batch.removed_keyframes.empty() || !batch.removed_points.empty() ||
                     !batch.replacements.empty();
  TouchByOwner(state, local_map.id, share);
}

}  // namespace corbslam::map_store
