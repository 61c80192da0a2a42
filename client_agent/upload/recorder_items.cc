// Takes keyframes and points into a batch, in full and light ones.
#include <algorithm>
#include <cstdlib>
#include <optional>
#include <utility>

#include "client_agent/upload/keyframe_depths.h"
#include "client_agent/upload/update_recorder.h"
#include "slam/exchange/item_checks.h"

namespace corbslam::client_agent {
namespace {

// A keyframe's picture doesn't tell so small a shift: an observation's noise is a pixel at its
// finest.
constexpr double kSameLook_px = 0.5;
// Of what travels as 32-bit numbers, relative to its size.
constexpr double kRounding = 1e-6;

}  // namespace

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

KeyframeId UpdateRecorder::FirstHeldBack(const Map& map) const {
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
  const KeyframeId first_held_back = FirstHeldBack(map);
  while (!added_keyframes_.empty() && batch.full_keyframes.size() < allowance.max_keyframes() &&
         (batch.full_keyframes.empty() || !allowance.is_spent())) {
    const KeyframeId id = *added_keyframes_.begin();
    if (first_held_back.IsValid() && id >= first_held_back && !IsOverdue(map, id)) break;
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

FullMapPoint UpdateRecorder::DescribePoint(const MapPoint& point, KeyframeId reference) {
  return {point.id,          point.position_in_map, reference,
          point.descriptor,  point.normal_in_map,   point.min_distance,
          point.max_distance};
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
    const FullMapPoint full = DescribePoint(*point, reference);
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

}  // namespace corbslam::client_agent
