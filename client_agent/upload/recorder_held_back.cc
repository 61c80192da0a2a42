// What an UpdateRecorder has been told and has not told, for the next process.
#include "client_agent/upload/update_recorder.h"
#include "slam/exchange/item_checks.h"

namespace corbslam::client_agent {

void UpdateRecorder::GoOnFrom(const SpooledMap& spooled_map) {
  absl::MutexLock lock(&mutex_);
  sent_cameras_ = static_cast<uint32_t>(spooled_map.cameras().size());
  mirror_ = spooled_map.observations();
  for (const auto& [id, keyframe] : spooled_map.keyframes()) {
    sent_keyframes_.insert(id);
    believed_.PlaceKeyframe(id, keyframe.camera_from_local);
  }
  for (const auto& [id, point] : spooled_map.points()) {
    sent_points_.insert(id);
    const bool moves = sent_keyframes_.contains(point.reference);
    // Without its reference a point stays where it is.
    if (!moves) believed_.PlaceKeyframe(point.reference, Rigid3d::Identity());
    believed_.AddPoint(id, point.position_in_local, point.reference);
    if (!moves) believed_.RemoveKeyframe(point.reference);
  }
}

void UpdateRecorder::CopyHeldBackAnew() {
  absl::MutexLock lock(&mutex_);
  held_back_numbers_.clear();
  ++held_back_changes_;
}

uint64_t UpdateRecorder::held_back_changes() const {
  absl::MutexLock lock(&mutex_);
  return held_back_changes_;
}

uint32_t UpdateRecorder::NumberOf(KeyframeId id, uint32_t keypoint) const {
  const auto held_back = held_back_numbers_.find(id);
  if (held_back == held_back_numbers_.end()) return NumberAtStore(id, keypoint);
  return held_back->second.empty() ? keypoint : held_back->second[keypoint];
}

void UpdateRecorder::CopyHeldBackKeyframes(const Map& map, HeldBackItems& held_back) {
  absl::erase_if(held_back_numbers_,
                 [this](const auto& entry) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
                   return !added_keyframes_.contains(entry.first);
                 });
  for (const KeyframeId id : added_keyframes_) {
    const Keyframe* keyframe = map.FindKeyframe(id);
    if (keyframe == nullptr || held_back_numbers_.contains(id)) continue;
    SelectedFeatures selected = SelectFeatures(*keyframe, options_.features);
    FullKeyframe full = {selected.payload, keyframe->camera_from_map, KeyframeId()};
    // The next batch counts and logs it.
    if (!ValidateFullKeyframe(full, *full.payload->camera).ok()) continue;
    held_back_numbers_[id] = std::move(selected.numbers);
    held_back.keyframes.push_back(std::move(full));
  }
  for (const auto& [id, numbers] : held_back_numbers_) {
    const Keyframe* keyframe = map.FindKeyframe(id);
    if (keyframe == nullptr) continue;
    const Keyframe* above = keyframe;
    while (above != nullptr && !IsToldOrHeldBack(above->parent)) {
      above = map.FindKeyframe(above->parent);
    }
    const KeyframeId parent = above == nullptr ? KeyframeId() : above->parent;
    held_back.rest.light_keyframes.push_back({id, keyframe->camera_from_map, parent});
  }
}

void UpdateRecorder::CopyHeldBackPoints(const Map& map, MapUpdateBatch& rest) const {
  for (const MapPointId id : added_points_) {
    const MapPoint* point = map.FindPoint(id);
    if (point == nullptr || sent_points_.contains(id)) continue;
    KeyframeId reference;
    for (const auto& [keyframe, keypoint] : point->observations) {
      const bool told = IsToldOrHeldBack(keyframe) && NumberOf(keyframe, keypoint) != kLeftOut;
      if (told && (!reference.IsValid() || keyframe == point->reference)) reference = keyframe;
    }
    if (!reference.IsValid()) continue;
    const FullMapPoint full = DescribePoint(*point, reference);
    if (ValidateFullPoint(full).ok()) rest.full_points.push_back(full);
  }
}

void UpdateRecorder::CopyHeldBackObservations(const Map& map, MapUpdateBatch& rest) const {
  const auto add = [&](MapPointId point, KeyframeId keyframe,
                       uint32_t keypoint) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    const uint32_t number = NumberOf(keyframe, keypoint);
    if (number == kLeftOut) return;
    rest.observations.push_back({ObservationChange::Kind::kAdded, point, keyframe, number});
  };
  absl::btree_set<MapPointId> held_back;
  for (const FullMapPoint& full : rest.full_points) {
    held_back.insert(full.id);
    for (const auto& [keyframe, keypoint] : map.FindPoint(full.id)->observations) {
      if (IsToldOrHeldBack(keyframe)) add(full.id, keyframe, keypoint);
    }
  }
  for (const LightKeyframe& light : rest.light_keyframes) {
    const std::vector<MapPointId>& points = map.FindKeyframe(light.id)->points;
    for (uint32_t k = 0; k < points.size(); ++k) {
      if (!points[k].IsValid() || held_back.contains(points[k])) continue;
      if (!IsOwn(points[k]) || sent_points_.contains(points[k])) add(points[k], light.id, k);
    }
  }
}

void UpdateRecorder::CopyHeldBackFrames(MapUpdateBatch& rest) const {
  for (const TrackedFrame& frame : tracked_frames_) {
    const bool good = IsToldOrHeldBack(frame.reference) &&
                      ValidateTime("tracked frame", frame.timestamp_ns).ok() &&
                      ValidatePose("tracked frame of", frame.reference, "reference_from_camera",
                                   frame.reference_from_camera)
                          .ok();
    if (good) rest.tracked_frames.push_back(frame);
  }
  for (const int64_t lost_ns : lost_frames_ns_) {
    if (ValidateTime("lost frame", lost_ns).ok()) rest.lost_frames_ns.push_back(lost_ns);
  }
}

HeldBackItems UpdateRecorder::CopyHeldBack(const Map& map) {
  absl::MutexLock lock(&mutex_);
  HeldBackItems held_back;
  held_back.rest.local_map = local_map_;
  CopyHeldBackKeyframes(map, held_back);
  CopyHeldBackPoints(map, held_back.rest);
  CopyHeldBackObservations(map, held_back.rest);
  CopyHeldBackFrames(held_back.rest);
  return held_back;
}

}  // namespace corbslam::client_agent
