#include "client_agent/upload/update_recorder.h"

#include <algorithm>
#include <utility>

#include "client_agent/upload/outbox.h"

namespace corbslam::client_agent {
void UpdateRecorder::OnKeyframeAdded(KeyframeId id) {
  if (!IsOwn(id)) return;
  absl::MutexLock lock(&mutex_);
  added_keyframes_.insert(id);
  ++held_back_changes_;
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
  if (!IsOwn(id)) return;
  added_points_.insert(id);
  ++held_back_changes_;
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
  ++held_back_changes_;
  holds_back_ = true;
}

void UpdateRecorder::AddLostFrame(int64_t timestamp_ns) {
  absl::MutexLock lock(&mutex_);
  lost_frames_ns_.push_back(timestamp_ns);
  newest_frame_ns_ = timestamp_ns;
  ++held_back_changes_;
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

void UpdateRecorder::HoldBack() {
  absl::MutexLock lock(&mutex_);
  holds_back_ = true;
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
  ++held_back_changes_;
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

}  // namespace corbslam::client_agent
