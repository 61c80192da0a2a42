#include "client_agent/upload/spooled_map.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "slam/exchange/item_checks.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

template <typename Id>
absl::Status Unknown(absl::string_view what, Id id) {
  return absl::InvalidArgumentError(absl::StrCat(what, " ", ToString(id), " is not in the map"));
}

Rigid3d Normalised(const Rigid3d& pose) { return {pose.rotation.normalized(), pose.translation}; }

}  // namespace

absl::Status SpooledMap::AddCameras(const MapUpdateBatch& batch) {
  if (batch.cameras.empty()) return absl::OkStatus();
  if (batch.first_camera_index > cameras_.size()) {
    return absl::InvalidArgumentError(absl::StrCat("cameras from index ", batch.first_camera_index,
                                                   ", but ", cameras_.size(), " are known"));
  }
  for (size_t i = 0; i < batch.cameras.size(); ++i) {
    const size_t index = batch.first_camera_index + i;
    if (batch.cameras[i] == nullptr) {
      return absl::InvalidArgumentError(absl::StrCat("camera ", index, " is empty"));
    }
    RETURN_IF_ERROR(Validate(*batch.cameras[i]));
    if (index < cameras_.size()) {
      if (*cameras_[index] == *batch.cameras[i]) continue;
      return absl::InvalidArgumentError(
          absl::StrCat("camera ", index, " differs from what was told before"));
    }
    cameras_.push_back(batch.cameras[i]);
    recorded_.emplace_back();
    if (i < batch.recorded_cameras.size()) recorded_.back() = batch.recorded_cameras[i];
  }
  return absl::OkStatus();
}

absl::Status SpooledMap::AddKeyframe(FullKeyframe keyframe) {
  if (keyframe.payload == nullptr) return absl::InvalidArgumentError("keyframe without payload");
  const KeyframeId id = keyframe.payload->id;
  RETURN_IF_ERROR(ValidateOwn("keyframe", id, local_map_));
  if (keyframe.payload->camera_index >= cameras_.size()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "keyframe ", ToString(id), ": camera ", keyframe.payload->camera_index, " was never told"));
  }
  const auto& camera = cameras_[keyframe.payload->camera_index];
  RETURN_IF_ERROR(ValidateFullKeyframe(keyframe, *camera));
  if (keyframe.payload->camera == nullptr) keyframe.payload = WithCamera(*keyframe.payload, camera);
  if (keyframe.parent.IsValid() && keyframe.parent.local_map != local_map_) {
    return Unknown("parent", keyframe.parent);
  }
  keyframe.code = nullptr;
  keyframe.camera_from_local = Normalised(keyframe.camera_from_local);
  observations_.AddKeyframe(id, keyframe.payload->features.keypoints.size());
  NoteIndex(id);
  NoteTime(keyframe.payload->timestamp_ns);
  if (keyframes_.emplace(id, std::move(keyframe)).second) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("keyframe ", ToString(id), " was told before"));
}

absl::Status SpooledMap::AddPoint(const FullMapPoint& point) {
  RETURN_IF_ERROR(ValidateOwn("map point", point.id, local_map_));
  RETURN_IF_ERROR(ValidateFullPoint(point));
  NoteIndex(point.id);
  if (!points_.emplace(point.id, point).second) {
    return absl::InvalidArgumentError(
        absl::StrCat("map point ", ToString(point.id), " was told before"));
  }
  followers_.Add(point.reference, point.id);
  return absl::OkStatus();
}

absl::Status SpooledMap::MoveKeyframe(const LightKeyframe& light, bool points_follow) {
  RETURN_IF_ERROR(ValidateLightKeyframe(light));
  const auto it = keyframes_.find(light.id);
  if (it == keyframes_.end()) return Unknown("keyframe", light.id);
  const Rigid3d now = Normalised(light.camera_from_local);
  const Rigid3d local_from_before = now.Inverse() * it->second.camera_from_local;
  it->second.camera_from_local = now;
  if (light.parent.IsValid()) it->second.parent = light.parent;
  if (!points_follow) return absl::OkStatus();
  const auto follows = [this](MapPointId point) { return points_.contains(point); };
  for (const MapPointId id : followers_.Of(light.id, follows)) {
    Eigen::Vector3d& position = points_.at(id).position_in_local;
    position = local_from_before * position;
  }
  return absl::OkStatus();
}

absl::Status SpooledMap::MovePoint(const LightMapPoint& light) {
  RETURN_IF_ERROR(
      ValidatePosition("light map point", light.id, "position", light.position_in_local));
  const auto it = points_.find(light.id);
  if (it == points_.end()) return Unknown("map point", light.id);
  it->second.position_in_local = light.position_in_local;
  return absl::OkStatus();
}

absl::Status SpooledMap::Replace(const PointReplacement& replacement) {
  const MapPointId survivor = replacement.survivor;
  if (survivor.local_map == local_map_ && !points_.contains(survivor)) {
    return Unknown("survivor", survivor);
  }
  if (survivor == replacement.replaced || points_.erase(replacement.replaced) == 0) {
    return Unknown("replaced point", replacement.replaced);
  }
  observations_.ReplacePoint(replacement.replaced, survivor);
  return absl::OkStatus();
}

absl::Status SpooledMap::Observe(const ObservationChange& change) {
  const bool is_added = change.kind == ObservationChange::Kind::kAdded;
  if (is_added && change.point.local_map == local_map_ && !points_.contains(change.point)) {
    return Unknown("observed point", change.point);
  }
  if (observations_.Apply(change)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("observation of ", ToString(change.point), " by keypoint ", change.keypoint,
                   " of keyframe ", ToString(change.keyframe), ", which has no such keypoint"));
}

// Keyframes may be told to be gone that were never told.
void SpooledMap::Remove(const KeyframeRemoval& removal) {
  NoteIndex(removal.id);
  const auto it = keyframes_.find(removal.id);
  if (it == keyframes_.end()) return;
  const KeyframeId parent = it->second.parent;
  keyframes_.erase(it);
  observations_.RemoveKeyframe(removal.id);
  followers_.Forget(removal.id);
  for (auto& [id, keyframe] : keyframes_) {
    if (keyframe.parent == removal.id) keyframe.parent = parent;
  }
  absl::erase_if(loop_edges_, [&](const auto& edge) {
    return edge.first == removal.id || edge.second == removal.id;
  });
}

absl::Status SpooledMap::Apply(const MapUpdateBatch& batch) {
  if (batch.local_map != local_map_) {
    return absl::InvalidArgumentError(absl::StrCat("the batch is of local map ",
                                                   ToString(batch.local_map), ", not of ",
                                                   ToString(local_map_)));
  }
  RETURN_IF_ERROR(AddCameras(batch));
  for (const FullKeyframe& keyframe : batch.full_keyframes) RETURN_IF_ERROR(AddKeyframe(keyframe));
  for (const FullMapPoint& point : batch.full_points) RETURN_IF_ERROR(AddPoint(point));
  for (const LightKeyframe& light : batch.light_keyframes) {
    RETURN_IF_ERROR(MoveKeyframe(light, batch.points_follow));
  }
  for (const LightMapPoint& light : batch.light_points) RETURN_IF_ERROR(MovePoint(light));
  for (const PointReplacement& replacement : batch.replacements) {
    RETURN_IF_ERROR(Replace(replacement));
  }
  for (const ObservationChange& change : batch.observations) RETURN_IF_ERROR(Observe(change));
  for (const MapPointId& id : batch.removed_points) {
    NoteIndex(id);
    if (points_.erase(id) > 0) observations_.RemovePoint(id);
  }
  for (const KeyframeRemoval& removal : batch.removed_keyframes) Remove(removal);
  for (const LoopEdge& edge : batch.loop_edges) {
    if (keyframes_.contains(edge.a) && keyframes_.contains(edge.b)) {
      loop_edges_.insert({edge.a, edge.b});
    }
  }
  NoteFrames(batch);
  return absl::OkStatus();
}

void SpooledMap::NoteFrames(const MapUpdateBatch& batch) {
  for (const TrackedFrame& frame : batch.tracked_frames) {
    NoteTime(frame.timestamp_ns);
    NoteIndex(frame.reference);
  }
  for (const int64_t lost_ns : batch.lost_frames_ns) NoteTime(lost_ns);
}

void SpooledMap::NoteTime(int64_t timestamp_ns) {
  newest_ns_ = std::max(newest_ns_.value_or(timestamp_ns), timestamp_ns);
}

void SpooledMap::NoteIndex(KeyframeId id) {
  if (id.local_map == local_map_) next_keyframe_ = std::max(next_keyframe_, id.index + 1);
}

void SpooledMap::NoteIndex(MapPointId id) {
  if (id.local_map == local_map_) next_point_ = std::max(next_point_, id.index + 1);
}

absl::Status SpooledMap::Check() const {
  if (keyframes_.empty()) return absl::InvalidArgumentError("it has no keyframe");
  std::optional<KeyframeId> root;
  for (const auto& [id, keyframe] : keyframes_) {
    if (keyframe.parent.IsValid()) {
      if (!keyframes_.contains(keyframe.parent)) return Unknown("parent", keyframe.parent);
      continue;
    }
    if (root.has_value()) {
      return absl::InvalidArgumentError(absl::StrCat("both keyframe ", ToString(*root), " and ",
                                                     ToString(id), " hang on no other"));
    }
    root = id;
  }
  for (const auto& [id, keyframe] : keyframes_) {
    size_t steps = 0;
    for (KeyframeId at = id; at.IsValid(); at = keyframes_.at(at).parent) {
      if (++steps <= keyframes_.size()) continue;
      return absl::InvalidArgumentError(
          absl::StrCat("keyframe ", ToString(id), " hangs on itself"));
    }
  }
  return absl::OkStatus();
}

}  // namespace corbslam::client_agent
