#include "client_agent/upload/update_recorder.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "client_agent/upload/keyframe_depths.h"
#include "client_agent/upload/outbox.h"
#include "slam/exchange/item_checks.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

// What a keyframe's picture doesn't tell: an observation's noise is a pixel at its finest.
constexpr double kSameLook_px = 0.5;
// Of what travels as 32-bit numbers, relative to its size.
constexpr double kRounding = 1e-6;

absl::Status ValidateFrame(const TrackedFrame& frame) {
  RETURN_IF_ERROR(ValidateTime("tracked frame", frame.timestamp_ns));
  return ValidatePose("tracked frame of", frame.reference, "reference_from_camera",
                      frame.reference_from_camera);
}

}  // namespace

void UpdateRecorder::OnKeyframeAdded(KeyframeId id) {
  if (!IsOwn(id)) return;
  absl::MutexLock lock(&mutex_);
  added_keyframes_.insert(id);
}

void UpdateRecorder::OnKeyframeMoved(KeyframeId id) {
  if (!IsOwn(id)) return;
  absl::MutexLock lock(&mutex_);
  changed_keyframes_.insert(id);
}

void UpdateRecorder::OnParentChanged(KeyframeId id) { OnKeyframeMoved(id); }

void UpdateRecorder::OnLoopEdgeAdded(KeyframeId a, KeyframeId b) {
  if (!IsOwn(a)) std::swap(a, b);
  if (!IsOwn(a)) return;
  absl::MutexLock lock(&mutex_);
  loop_edges_.emplace_back(a, b);
}

void UpdateRecorder::OnKeyframeRemoved(KeyframeId id, KeyframeId parent,
                                       const Rigid3d& parent_from_removed) {
  if (!IsOwn(id)) return;
  absl::MutexLock lock(&mutex_);
  added_keyframes_.erase(id);
  changed_keyframes_.erase(id);
  reobserved_keyframes_.erase(id);
  // Told even if the keyframe never was: frames were tracked relative to it.
  removed_keyframes_.push_back({id, parent, parent_from_removed});
}

void UpdateRecorder::OnPointAdded(MapPointId id) {
  absl::MutexLock lock(&mutex_);
  // Others' points may come back, and then stand for themselves.
  replaced_points_.erase(id);
  if (IsOwn(id)) added_points_.insert(id);
}

void UpdateRecorder::OnPointMoved(MapPointId id) {
  if (!IsOwn(id)) return;
  absl::MutexLock lock(&mutex_);
  moved_points_.insert(id);
}

void UpdateRecorder::OnObservationAdded(MapPointId point, KeyframeId keyframe, uint32_t keypoint) {
  if (!IsOwn(keyframe)) return;
  absl::MutexLock lock(&mutex_);
  if (IsOwn(point)) (sent_points_.contains(point) ? moved_points_ : added_points_).insert(point);
  const auto withdrawn = withdrawn_.find({keyframe, keypoint});
  if (withdrawn != withdrawn_.end() && withdrawn->second == point) withdrawn_.erase(withdrawn);
  reobserved_keyframes_.insert(keyframe);
}

void UpdateRecorder::OnObservationRemoved(MapPointId point, KeyframeId keyframe,
                                          uint32_t keypoint) {
  OnObservationAdded(point, keyframe, keypoint);
  if (!IsOwn(keyframe) || IsOwn(point)) return;
  absl::MutexLock lock(&mutex_);
  withdrawn_[{keyframe, keypoint}] = point;
}

void UpdateRecorder::OnPointReplaced(MapPointId replaced, MapPointId survivor) {
  absl::MutexLock lock(&mutex_);
  if (IsOwn(survivor)) {
    (sent_points_.contains(survivor) ? moved_points_ : added_points_).insert(survivor);
  }
  replaced_points_[replaced] = survivor;
}

void UpdateRecorder::OnPointRemoved(MapPointId id) {
  if (!IsOwn(id)) return;
  absl::MutexLock lock(&mutex_);
  removed_points_.insert(id);
}

void UpdateRecorder::SetPointsFollow(bool points_follow) {
  absl::MutexLock lock(&mutex_);
  if (points_follow == std::exchange(points_follow_, points_follow) || points_follow) return;
  believed_.ForgetPlaces();
  moved_points_.insert(sent_points_.begin(), sent_points_.end());
}

void UpdateRecorder::AddTrackedFrame(const TrackedFrame& frame) {
  absl::MutexLock lock(&mutex_);
  tracked_frames_.push_back(frame);
  newest_frame_ns_ = frame.timestamp_ns;
  holds_back_ = true;
}

void UpdateRecorder::AddLostFrame(int64_t timestamp_ns) {
  absl::MutexLock lock(&mutex_);
  lost_frames_ns_.push_back(timestamp_ns);
  newest_frame_ns_ = timestamp_ns;
  holds_back_ = true;
}

bool UpdateRecorder::MayChangeKeypoints(KeyframeId id) const {
  absl::MutexLock lock(&mutex_);
  return !sent_keyframes_.contains(id);
}

void UpdateRecorder::AskForExactPlaces() {
  absl::MutexLock lock(&mutex_);
  exactly_ = true;
  moved_points_.insert(sent_points_.begin(), sent_points_.end());
}

void UpdateRecorder::StopHoldingBack() {
  absl::MutexLock lock(&mutex_);
  holds_back_ = false;
}

bool UpdateRecorder::HasChanges() const {
  absl::MutexLock lock(&mutex_);
  return HasMore();
}

bool UpdateRecorder::HasMore() const {
  return !(added_keyframes_.empty() && changed_keyframes_.empty() &&
           reobserved_keyframes_.empty() && added_points_.empty() && moved_points_.empty() &&
           replaced_points_.empty() && removed_points_.empty() && removed_keyframes_.empty() &&
           loop_edges_.empty() && tracked_frames_.empty() && lost_frames_ns_.empty());
}

uint64_t UpdateRecorder::refused_items() const {
  absl::MutexLock lock(&mutex_);
  return gate_.refused();
}

size_t UpdateRecorder::pending_keyframes() const {
  absl::MutexLock lock(&mutex_);
  return added_keyframes_.size() - std::min(added_keyframes_.size(), options_.hold_newest);
}

UpdateCounts UpdateRecorder::CountUntold() const {
  absl::MutexLock lock(&mutex_);
  return {changed_keyframes_.size() + tracked_frames_.size() + lost_frames_ns_.size(),
          added_keyframes_.size(), added_points_.size(), moved_points_.size()};
}

MapUpdateBatch UpdateRecorder::TakeBatch(const Map& map, BatchAllowance allowance) {
  absl::MutexLock lock(&mutex_);
  MapUpdateBatch batch;
  batch.local_map = local_map_;
  batch.points_follow = points_follow_;
  pairs_before_ = mirror_.pairs();
  SpendPoses(map, allowance);
  TakeFullKeyframes(map, allowance, batch);
  TakeFullPoints(map, allowance, batch);
  TakeLightKeyframes(map, batch);
  TakeLightPoints(map, allowance, batch);
  TakeReplacements(map, batch);
  TakeObservations(map, batch);
  TakeRemovals(batch);
  TakeLoopEdges(map, batch);
  TakeFrames(batch);
  // Of what is left nothing can be told: a point that only others' keyframes see may be so for
  // good.
  exactly_ = exactly_ && HasMore() && !IsEmpty(batch);
  return batch;
}

// Cameras go in the order of their indices, before the first keyframe of theirs.
void UpdateRecorder::TakeCameras(const FullKeyframe& keyframe, MapUpdateBatch& batch) {
  if (keyframe.payload->camera_index != sent_cameras_) return;
  if (batch.cameras.empty()) batch.first_camera_index = sent_cameras_;
  batch.cameras.push_back(keyframe.payload->camera);
  if (options_.recorded_camera.has_value()) {
    batch.recorded_cameras.push_back(*options_.recorded_camera);
  }
  ++sent_cameras_;
}

// The nearest ancestor of `id` that the store has been told of.
KeyframeId UpdateRecorder::KnownAncestor(const Map& map, KeyframeId id) const {
  const Keyframe* at = map.FindKeyframe(id);
  while (at != nullptr) {
    if (sent_keyframes_.contains(at->parent)) return at->parent;
    at = map.FindKeyframe(at->parent);
  }
  return KeyframeId();
}

KeyframeId UpdateRecorder::FirstHeld(const Map& map) const {
  if (options_.hold_newest == 0 || !holds_back_ || exactly_) return KeyframeId();
  const KeyframeId last_free = NewestBut(map, local_map_, options_.hold_newest);
  if (last_free.IsValid()) return {local_map_, last_free.index + 1};
  // The first is never taken out.
  const auto first = map.keyframes().lower_bound({local_map_, 0});
  return {local_map_, first == map.keyframes().end() ? 0 : first->first.index + 1};
}

bool UpdateRecorder::IsOverdue(const Map& map, KeyframeId id) const {
  const Keyframe* keyframe = map.FindKeyframe(id);
  // Sequences may be played backwards.
  return keyframe == nullptr ||
         std::abs(newest_frame_ns_ - keyframe->payload->timestamp_ns) > options_.hold_at_most_ns;
}

void UpdateRecorder::SpendPoses(const Map& map, BatchAllowance& allowance) const {
  const auto keyframes =
      std::count_if(changed_keyframes_.begin(), changed_keyframes_.end(),
                    [&](KeyframeId id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
                      return sent_keyframes_.contains(id) && map.FindKeyframe(id) != nullptr;
                    });
  const auto frames =
      std::count_if(tracked_frames_.begin(), tracked_frames_.end(),
                    [&](const TrackedFrame& frame) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
                      return !added_keyframes_.contains(frame.reference);
                    });
  allowance.SpendPoses(static_cast<size_t>(keyframes), static_cast<size_t>(frames));
}

void UpdateRecorder::TakeFullKeyframes(const Map& map, BatchAllowance& allowance,
                                       MapUpdateBatch& batch) {
  const KeyframeId first_held = FirstHeld(map);
  while (!added_keyframes_.empty() && batch.full_keyframes.size() < allowance.max_keyframes() &&
         (batch.full_keyframes.empty() || !allowance.is_spent())) {
    const KeyframeId id = *added_keyframes_.begin();
    if (first_held.IsValid() && id >= first_held && !IsOverdue(map, id)) break;
    added_keyframes_.erase(added_keyframes_.begin());
    const Keyframe* keyframe = map.FindKeyframe(id);
    if (keyframe == nullptr) continue;
    SelectedFeatures selected = SelectFeatures(*keyframe, options_.features);
    FullKeyframe full = {selected.payload, keyframe->camera_from_map, KnownAncestor(map, id)};
    changed_keyframes_.erase(id);
    if (!gate_.Admit(ValidateFullKeyframe(full, *full.payload->camera))) {
      refused_keyframes_.insert(id);
      continue;
    }
    if (!selected.numbers.empty()) numbers_[id] = std::move(selected.numbers);
    NoteParent(*keyframe, full.parent);
    reobserved_keyframes_.insert(id);
    TakeCameras(full, batch);
    allowance.SpendKeyframe(full.payload->features.keypoints.size());
    sent_keyframes_.insert(id);
    mirror_.AddKeyframe(id, keyframe->points.size());
    believed_.PlaceKeyframe(id, keyframe->camera_from_map);
    batch.full_keyframes.push_back(std::move(full));
  }
}

uint32_t UpdateRecorder::NumberAtStore(KeyframeId id, uint32_t keypoint) const {
  const auto numbers = numbers_.find(id);
  return numbers == numbers_.end() ? keypoint : numbers->second[keypoint];
}

bool UpdateRecorder::IsSeenAtStore(const MapPoint& point) const {
  return std::ranges::any_of(point.observations,
                             [this](const auto& seen) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
                               return sent_keyframes_.contains(seen.first) &&
                                      NumberAtStore(seen.first, seen.second) != kLeftOut;
                             });
}

// Where nobody sees it there is nothing to tell until somebody does, and nor where all that do have
// been told without the feature.
bool UpdateRecorder::MayBeSeenLater(const Map& map, const MapPoint& point) const {
  if (options_.features.IsAll()) {
    return !point.observations.empty() || map.FindKeyframe(point.reference) != nullptr;
  }
  return std::ranges::any_of(point.observations,
                             [this](const auto& seen) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
                               return added_keyframes_.contains(seen.first);
                             });
}

KeyframeId UpdateRecorder::KnownReference(const MapPoint& point) const {
  if (!options_.features.IsAll() && !IsSeenAtStore(point)) return KeyframeId();
  if (sent_keyframes_.contains(point.reference)) return point.reference;
  for (const auto& [keyframe, keypoint] : point.observations) {
    if (sent_keyframes_.contains(keyframe)) return keyframe;
  }
  return KeyframeId();
}

void UpdateRecorder::TakeFullPoints(const Map& map, BatchAllowance& allowance,
                                    MapUpdateBatch& batch) {
  absl::btree_set<MapPointId> waiting;
  for (const MapPointId& id : added_points_) {
    const MapPoint* point = map.FindPoint(id);
    if (point == nullptr) continue;
    if (batch.full_points.size() == options_.limits.full_points || allowance.is_spent()) {
      waiting.insert(id);
      continue;
    }
    const KeyframeId reference = KnownReference(*point);
    if (!reference.IsValid()) {
      if (MayBeSeenLater(map, *point)) waiting.insert(id);
      continue;
    }
    const FullMapPoint full = {id,
                               point->position_in_map,
                               reference,
                               point->descriptor,
                               point->normal_in_map,
                               point->min_distance,
                               point->max_distance};
    if (!gate_.Admit(ValidateFullPoint(full))) continue;
    allowance.SpendPoint(point->observations.size());
    moved_points_.erase(id);
    sent_points_.insert(id);
    believed_.AddPoint(id, point->position_in_map, reference);
    batch.full_points.push_back(full);
  }
  added_points_ = std::move(waiting);
}

void UpdateRecorder::NoteParent(const Keyframe& keyframe, KeyframeId told) {
  if (told != keyframe.parent && IsOwn(keyframe.parent)) {
    stand_ins_[keyframe.id()] = told;
  } else {
    stand_ins_.erase(keyframe.id());
  }
}

void UpdateRecorder::TakeLightKeyframes(const Map& map, MapUpdateBatch& batch) {
  for (const auto& [id, told] : stand_ins_) {
    if (KnownAncestor(map, id) != told) changed_keyframes_.insert(id);
  }
  // Root first, so that no step of the new tree makes a cycle with what is left of the old one: all
  // ancestors hang where they shall already. So it is where this batch ends before the last one,
  // too, and whatever becomes of the tree until the next: there the rest is sorted by the tree of
  // then.
  KeyframeDepths depths(map);
  std::vector<std::pair<size_t, KeyframeId>> by_depth;
  for (const KeyframeId& id : changed_keyframes_) {
    if (!sent_keyframes_.contains(id) || map.FindKeyframe(id) == nullptr) continue;
    by_depth.emplace_back(depths.Of(id), id);
  }
  std::sort(by_depth.begin(), by_depth.end());
  changed_keyframes_.clear();
  for (const auto& [depth, id] : by_depth) {
    if (batch.light_keyframes.size() == options_.limits.light_keyframes) {
      changed_keyframes_.insert(id);
      continue;
    }
    const Keyframe& keyframe = *map.FindKeyframe(id);
    const KeyframeId parent = KnownAncestor(map, id);
    const LightKeyframe light = {id, keyframe.camera_from_map, parent};
    if (!gate_.Admit(ValidateLightKeyframe(light))) continue;
    NoteParent(keyframe, parent);
    batch.light_keyframes.push_back(light);
    believed_.PlaceKeyframe(id, keyframe.camera_from_map, points_follow_);
    // Where it sees points, and where it took those that follow it.
    for (const MapPointId point : keyframe.points) {
      if (point.IsValid() && IsOwn(point)) moved_points_.insert(point);
    }
    for (const MapPointId point : believed_.Followers(id)) moved_points_.insert(point);
  }
}

bool UpdateRecorder::IsToldWell(const Map& map, const MapPoint& point) const {
  const std::optional<Eigen::Vector3d> told = believed_.Position(point.id);
  if (!told.has_value()) return false;
  if (!exactly_) return LooksTheSame(map, point, *told, kSameLook_px);
  return (*told - point.position_in_map).norm() <= kRounding * (1 + point.position_in_map.norm());
}

bool UpdateRecorder::AreLightPointsDue() const {
  if (options_.hold_newest == 0 || !holds_back_ || exactly_ || !points_told_ns_) return true;
  return std::abs(newest_frame_ns_ - *points_told_ns_) >= options_.light_points_every_ns;
}

void UpdateRecorder::TakeLightPoints(const Map& map, BatchAllowance& allowance,
                                     MapUpdateBatch& batch) {
  if (moved_points_.empty() || !AreLightPointsDue()) return;
  while (!moved_points_.empty() && batch.light_points.size() < options_.limits.light_points &&
         !allowance.is_spent()) {
    const MapPointId id = *moved_points_.begin();
    moved_points_.erase(moved_points_.begin());
    const MapPoint* point = map.FindPoint(id);
    if (point == nullptr || !sent_points_.contains(id)) continue;
    if (!gate_.Admit(ValidatePosition("light map point", id, "position", point->position_in_map)) ||
        IsToldWell(map, *point)) {
      continue;
    }
    allowance.SpendLightPoint();
    believed_.MovePoint(id, point->position_in_map);
    batch.light_points.push_back({id, point->position_in_map});
  }
  if (moved_points_.empty()) points_told_ns_ = newest_frame_ns_;
}

MapPointId UpdateRecorder::ResolveSurvivor(const Map& map, MapPointId replaced) const {
  MapPointId survivor = replaced;
  for (auto it = replaced_points_.find(survivor); it != replaced_points_.end();
       it = replaced_points_.find(survivor)) {
    survivor = it->second;
  }
  return map.FindPoint(survivor) == nullptr ? MapPointId() : survivor;
}

// Keypoints that the store takes to see the survivor since it stands for the replaced point, but
// that don't: where they saw it already with another one, or do no more.
void UpdateRecorder::NoteWithdrawn(const Map& map, const std::map<KeyframeId, uint32_t>& replaced,
                                   MapPointId survivor) {
  const MapPoint& point = *map.FindPoint(survivor);
  for (const auto& [id, keypoint] : replaced) {
    if (!point.observations.contains(id)) withdrawn_[{id, keypoint}] = survivor;
  }
}

void UpdateRecorder::TakeReplacements(const Map& map, MapUpdateBatch& batch) {
  absl::btree_map<MapPointId, MapPointId> waiting;
  for (const auto& [replaced, last_survivor] : replaced_points_) {
    if (!sent_points_.contains(replaced)) continue;
    const MapPointId survivor = ResolveSurvivor(map, replaced);
    if (!survivor.IsValid()) {
      removed_points_.insert(replaced);
      continue;
    }
    if (IsOwn(survivor) && !sent_points_.contains(survivor)) {
      // Seen by nobody any more it is not told, and what it replaced is not there either.
      if (added_points_.contains(survivor)) {
        waiting.emplace(replaced, survivor);
      } else {
        removed_points_.insert(replaced);
      }
      continue;
    }
    if (batch.replacements.size() == options_.limits.replacements || IsOutOfPairs()) {
      waiting.emplace(replaced, survivor);
      continue;
    }
    const std::map<KeyframeId, uint32_t> observations = mirror_.Observations(replaced);
    for (const auto& [id, keypoint] : observations) reobserved_keyframes_.insert(id);
    mirror_.ReplacePoint(replaced, survivor);
    if (!IsOwn(survivor)) NoteWithdrawn(map, observations, survivor);
    sent_points_.erase(replaced);
    believed_.RemovePoint(replaced);
    batch.replacements.push_back({replaced, survivor});
  }
  for (const auto& [replaced, last_survivor] : replaced_points_) {
    const MapPoint* survivor = map.FindPoint(ResolveSurvivor(map, replaced));
    if (survivor == nullptr) continue;
    for (const auto& [id, keypoint] : survivor->observations) {
      if (IsOwn(id)) reobserved_keyframes_.insert(id);
    }
  }
  replaced_points_ = std::move(waiting);
}

void UpdateRecorder::TakeObservations(const Map& map, MapUpdateBatch& batch) {
  absl::btree_set<KeyframeId> waiting;
  const auto can_tell = [this](MapPointId id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return !IsOwn(id) || sent_points_.contains(id);
  };
  const auto has_room = [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return batch.observations.size() < options_.limits.observations && !IsOutOfPairs();
  };
  for (const KeyframeId& id : reobserved_keyframes_) {
    const Keyframe* keyframe = map.FindKeyframe(id);
    if (keyframe == nullptr || refused_keyframes_.contains(id)) continue;
    if (!has_room()) {
      waiting.insert(id);
      continue;
    }
    const auto is_withdrawn = [&](uint32_t keypoint) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return withdrawn_.contains({id, keypoint});
    };
    const auto is_sent = [&](uint32_t keypoint) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return NumberAtStore(id, keypoint) != kLeftOut;
    };
    if (!sent_keyframes_.contains(id) ||
        !mirror_.AppendChanges(*keyframe, {can_tell, is_withdrawn, is_sent, has_room},
                               batch.observations)) {
      waiting.insert(id);
    }
  }
  for (ObservationChange& change : batch.observations) {
    change.keypoint = NumberAtStore(change.keyframe, change.keypoint);
  }
  absl::erase_if(withdrawn_, [&waiting](const auto& withdrawn) {
    return !waiting.contains(withdrawn.first.first);
  });
  reobserved_keyframes_ = std::move(waiting);
}

void UpdateRecorder::TakeRemovals(MapUpdateBatch& batch) {
  while (!removed_points_.empty() && !IsOutOfPairs() &&
         batch.removed_points.size() < options_.limits.removed_points) {
    const MapPointId id = *removed_points_.begin();
    removed_points_.erase(removed_points_.begin());
    if (sent_points_.erase(id) == 0) continue;
    mirror_.RemovePoint(id);
    believed_.RemovePoint(id);
    batch.removed_points.push_back(id);
  }
  // A keyframe goes after its children hang on others.
  if (!changed_keyframes_.empty()) return;
  auto removal = removed_keyframes_.begin();
  for (; removal != removed_keyframes_.end() &&
         batch.removed_keyframes.size() < options_.limits.removed_keyframes && !IsOutOfPairs();
       ++removal) {
    sent_keyframes_.erase(removal->id);
    numbers_.erase(removal->id);
    stand_ins_.erase(removal->id);
    mirror_.RemoveKeyframe(removal->id);
    believed_.RemoveKeyframe(removal->id);
    // Frames that name it may still come.
    if (refused_keyframes_.contains(removal->id)) continue;
    if (gate_.Admit(ValidateRemoval(*removal))) batch.removed_keyframes.push_back(*removal);
  }
  removed_keyframes_.erase(removed_keyframes_.begin(), removal);
}

void UpdateRecorder::TakeLoopEdges(const Map& map, MapUpdateBatch& batch) {
  std::vector<std::pair<KeyframeId, KeyframeId>> waiting;
  for (const auto& [a_id, b_id] : loop_edges_) {
    const Keyframe* a = map.FindKeyframe(a_id);
    const Keyframe* b = map.FindKeyframe(b_id);
    if (a == nullptr || b == nullptr) continue;
    if (refused_keyframes_.contains(a_id) || refused_keyframes_.contains(b_id)) continue;
    if (batch.loop_edges.size() == options_.limits.loop_edges || !sent_keyframes_.contains(a_id) ||
        (IsOwn(b_id) && !sent_keyframes_.contains(b_id))) {
      waiting.emplace_back(a_id, b_id);
      continue;
    }
    const Rigid3d b_from_a = b->camera_from_map * a->camera_from_map.Inverse();
    const Similarity3d similarity = Similarity3d::FromRigid(b_from_a);
    if (!gate_.Admit(ValidateSimilarity("loop edge from", a_id, similarity))) continue;
    batch.loop_edges.push_back({a_id, b_id, similarity});
  }
  loop_edges_ = std::move(waiting);
}

// A frame goes up with or after its reference keyframe.
void UpdateRecorder::TakeFrames(MapUpdateBatch& batch) {
  std::vector<TrackedFrame> waiting;
  for (const TrackedFrame& frame : tracked_frames_) {
    // Where its keyframe was not told, nobody can tell where it was.
    if (refused_keyframes_.contains(frame.reference)) continue;
    const bool waits = added_keyframes_.contains(frame.reference) ||
                       batch.tracked_frames.size() == options_.limits.frames;
    if (!waits && !gate_.Admit(ValidateFrame(frame))) continue;
    (waits ? waiting : batch.tracked_frames).push_back(frame);
  }
  tracked_frames_ = std::move(waiting);
  auto lost = lost_frames_ns_.begin();
  for (; lost != lost_frames_ns_.end() && batch.lost_frames_ns.size() < options_.limits.frames;
       ++lost) {
    if (gate_.Admit(ValidateTime("lost frame", *lost))) batch.lost_frames_ns.push_back(*lost);
  }
  lost_frames_ns_.erase(lost_frames_ns_.begin(), lost);
}

}  // namespace corbslam
