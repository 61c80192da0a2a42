#include "map_store/batch_validation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <set>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Positions beyond this are no place on earth; squares of it are far from overflow.
constexpr double kMaxCoordinate = 1e8;
constexpr double kUnitNormTolerance = 1e-3;

bool IsPosition(const Eigen::Vector3d& position) {
  return position.allFinite() && position.cwiseAbs().maxCoeff() <= kMaxCoordinate;
}

bool IsRotation(const Eigen::Quaterniond& rotation) {
  return rotation.coeffs().allFinite() && std::abs(rotation.norm() - 1) <= kUnitNormTolerance;
}

bool IsPose(const Rigid3d& pose) {
  return IsRotation(pose.rotation) && IsPosition(pose.translation);
}

template <typename Id>
absl::Status BadValue(absl::string_view what, Id id, absl::string_view field) {
  return absl::InvalidArgumentError(absl::StrCat(what, " ", ToString(id), ": ", field,
                                                 " is not finite, not of unit length or beyond ",
                                                 kMaxCoordinate));
}

// The id must be valid and of the batch's own local map.
template <typename Id>
absl::Status ValidateOwn(absl::string_view what, Id id, LocalMapId own) {
  if (!id.IsValid()) return absl::InvalidArgumentError(absl::StrCat(what, ": no id"));
  if (id.local_map == own) return absl::OkStatus();
  return absl::PermissionDeniedError(
      absl::StrCat(what, " ", ToString(id), " is not of the batch's local map ", ToString(own)));
}

template <typename Id>
absl::Status ValidateAny(absl::string_view what, Id id) {
  if (id.IsValid()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(what, ": no id"));
}

absl::Status ValidateCount(const MapUpdateBatch& batch, const MapStoreOptions& options) {
  const size_t items =
      batch.cameras.size() + batch.full_keyframes.size() + batch.full_points.size() +
      batch.light_keyframes.size() + batch.light_points.size() + batch.replacements.size() +
      batch.observations.size() + batch.removed_points.size() + batch.removed_keyframes.size() +
      batch.loop_edges.size() + batch.tracked_frames.size() + batch.lost_frames_ns.size();
  if (items <= options.max_items_per_batch) return absl::OkStatus();
  return absl::ResourceExhaustedError(absl::StrCat("batch ", batch.number, " has ", items,
                                                   " items; the limit is ",
                                                   options.max_items_per_batch));
}

absl::Status ValidateCameras(const LocalMapState* local_map, const MapUpdateBatch& batch) {
  constexpr size_t kMaxCameras = 16;
  const size_t known = local_map == nullptr ? 0 : local_map->cameras.size();
  if (batch.cameras.empty()) return absl::OkStatus();
  if (batch.first_camera_index > known ||
      batch.first_camera_index + batch.cameras.size() > kMaxCameras) {
    return absl::InvalidArgumentError(absl::StrCat("cameras from index ", batch.first_camera_index,
                                                   ": ", known, " are known, the limit is ",
                                                   kMaxCameras));
  }
  for (size_t i = 0; i < batch.cameras.size(); ++i) {
    const size_t index = batch.first_camera_index + i;
    if (batch.cameras[i] == nullptr) {
      return absl::InvalidArgumentError(absl::StrCat("camera ", index, " is empty"));
    }
    RETURN_IF_ERROR(Validate(*batch.cameras[i]));
    if (index < known && !(*local_map->cameras[index] == *batch.cameras[i])) {
      return absl::InvalidArgumentError(
          absl::StrCat("camera ", index, " differs from what was sent before"));
    }
  }
  return absl::OkStatus();
}

const Camera* FindCamera(const LocalMapState* local_map, const MapUpdateBatch& batch,
                         size_t index) {
  if (local_map != nullptr && index < local_map->cameras.size()) {
    return local_map->cameras[index].get();
  }
  if (index < batch.first_camera_index) return nullptr;
  const size_t offset = index - batch.first_camera_index;
  return offset < batch.cameras.size() ? batch.cameras[offset].get() : nullptr;
}

absl::Status ValidateFeatures(const KeyframePayload& payload, const MapStoreOptions& options) {
  const Features& features = payload.features;
  const size_t count = features.keypoints.size();
  if (count > options.max_keypoints_per_keyframe) {
    return absl::ResourceExhaustedError(absl::StrCat("keyframe ", ToString(payload.id), " has ",
                                                     count, " keypoints; the limit is ",
                                                     options.max_keypoints_per_keyframe));
  }
  if (features.descriptors.size() != count) {
    return absl::InvalidArgumentError(absl::StrCat("keyframe ", ToString(payload.id), " has ",
                                                   count, " keypoints but ",
                                                   features.descriptors.size(), " descriptors"));
  }
  for (const Keypoint& keypoint : features.keypoints) {
    const bool finite = std::isfinite(keypoint.x_px) && std::isfinite(keypoint.y_px) &&
                        std::isfinite(keypoint.disparity_px) && std::isfinite(keypoint.angle_rad);
    if (!finite || keypoint.octave >= ScalePyramid::kLevels) {
      return absl::InvalidArgumentError(
          absl::StrCat("keyframe ", ToString(payload.id),
                       " has a keypoint that is not finite or of octave ", keypoint.octave));
    }
  }
  return absl::OkStatus();
}

absl::Status ValidateFullKeyframe(const LocalMapState* local_map, const MapUpdateBatch& batch,
                                  const FullKeyframe& keyframe, const MapStoreOptions& options) {
  if (keyframe.payload == nullptr) {
    return absl::InvalidArgumentError("full keyframe without payload");
  }
  const KeyframePayload& payload = *keyframe.payload;
  RETURN_IF_ERROR(ValidateOwn("full keyframe", payload.id, batch.local_map));
  if (!IsPose(keyframe.camera_from_local)) return BadValue("keyframe", payload.id, "pose");
  if (keyframe.parent == payload.id) {
    return absl::InvalidArgumentError(
        absl::StrCat("keyframe ", ToString(payload.id), " is its own parent"));
  }
  const Camera* camera = FindCamera(local_map, batch, payload.camera_index);
  if (camera == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat("keyframe ", ToString(payload.id), ": camera ",
                                                   payload.camera_index, " was never sent"));
  }
  if (payload.camera != nullptr && !(*payload.camera == *camera)) {
    return absl::InvalidArgumentError(absl::StrCat("keyframe ", ToString(payload.id),
                                                   " carries another camera than index ",
                                                   payload.camera_index, " names"));
  }
  return ValidateFeatures(payload, options);
}

absl::Status ValidateKeyframes(const LocalMapState* local_map, const MapUpdateBatch& batch,
                               const MapStoreOptions& options) {
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    RETURN_IF_ERROR(ValidateFullKeyframe(local_map, batch, keyframe, options));
  }
  for (const LightKeyframe& keyframe : batch.light_keyframes) {
    RETURN_IF_ERROR(ValidateOwn("light keyframe", keyframe.id, batch.local_map));
    if (!IsPose(keyframe.camera_from_local)) return BadValue("keyframe", keyframe.id, "pose");
  }
  for (const KeyframeRemoval& removal : batch.removed_keyframes) {
    RETURN_IF_ERROR(ValidateOwn("removed keyframe", removal.id, batch.local_map));
    if (!IsPose(removal.parent_from_removed)) {
      return BadValue("removed keyframe", removal.id, "parent_from_removed");
    }
    if (removal.parent == removal.id) {
      return absl::InvalidArgumentError(
          absl::StrCat("removed keyframe ", ToString(removal.id), " is its own parent"));
    }
  }
  return absl::OkStatus();
}

absl::Status ValidatePoints(const MapUpdateBatch& batch) {
  for (const FullMapPoint& point : batch.full_points) {
    RETURN_IF_ERROR(ValidateOwn("full map point", point.id, batch.local_map));
    const bool finite = IsPosition(point.position_in_local) && point.normal_in_local.allFinite() &&
                        std::isfinite(point.min_distance) && std::isfinite(point.max_distance);
    if (!finite) return BadValue("map point", point.id, "position, normal or distance");
  }
  for (const LightMapPoint& point : batch.light_points) {
    RETURN_IF_ERROR(ValidateOwn("light map point", point.id, batch.local_map));
    if (!IsPosition(point.position_in_local)) return BadValue("map point", point.id, "position");
  }
  for (const PointReplacement& replacement : batch.replacements) {
    RETURN_IF_ERROR(ValidateOwn("replaced point", replacement.replaced, batch.local_map));
    RETURN_IF_ERROR(ValidateAny("survivor of a replacement", replacement.survivor));
    if (replacement.replaced == replacement.survivor) {
      return absl::InvalidArgumentError(
          absl::StrCat("point ", ToString(replacement.replaced), " replaces itself"));
    }
  }
  for (const MapPointId& id : batch.removed_points) {
    RETURN_IF_ERROR(ValidateOwn("removed point", id, batch.local_map));
  }
  return absl::OkStatus();
}

// Keypoints that a keyframe of the batch or of the map has; none when the keyframe is unknown.
std::optional<size_t> CountKeypoints(const LocalMapState* local_map,
                                     const std::map<KeyframeId, size_t>& in_batch, KeyframeId id) {
  if (const auto it = in_batch.find(id); it != in_batch.end()) return it->second;
  if (local_map == nullptr) return std::nullopt;
  const Keyframe* keyframe = local_map->map.FindKeyframe(id);
  if (keyframe == nullptr) return std::nullopt;
  return keyframe->keypoints().size();
}

absl::Status ValidateObservations(const LocalMapState* local_map, const MapUpdateBatch& batch,
                                  const MapStoreOptions& options) {
  std::map<KeyframeId, size_t> in_batch;
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    in_batch[keyframe.payload->id] = keyframe.payload->features.keypoints.size();
  }
  std::set<MapPointId> points_in_batch;
  for (const FullMapPoint& point : batch.full_points) points_in_batch.insert(point.id);
  size_t parked = local_map == nullptr ? 0 : local_map->parked.size();
  for (const ObservationChange& change : batch.observations) {
    RETURN_IF_ERROR(ValidateOwn("observing keyframe", change.keyframe, batch.local_map));
    RETURN_IF_ERROR(ValidateAny("observed point", change.point));
    const auto keypoints = CountKeypoints(local_map, in_batch, change.keyframe);
    const size_t limit = keypoints.value_or(options.max_keypoints_per_keyframe);
    const bool has_point = change.point.local_map != batch.local_map ||
                           points_in_batch.contains(change.point) ||
                           (local_map != nullptr && local_map->map.FindPoint(change.point));
    if (!keypoints.has_value() || !has_point) ++parked;
    if (change.kind == ObservationChange::Kind::kAdded && change.keypoint >= limit) {
      return absl::InvalidArgumentError(
          absl::StrCat("observation of ", ToString(change.point), " by keypoint ", change.keypoint,
                       " of keyframe ", ToString(change.keyframe), ", which has ", limit));
    }
  }
  if (parked > options.max_parked_references) {
    return absl::ResourceExhaustedError(
        absl::StrCat(parked, " references of local map ", ToString(batch.local_map),
                     " to what has not arrived; the limit is ", options.max_parked_references));
  }
  return absl::OkStatus();
}

absl::Status ValidateLoopEdges(const MapUpdateBatch& batch) {
  for (const LoopEdge& edge : batch.loop_edges) {
    RETURN_IF_ERROR(ValidateOwn("loop edge from", edge.a, batch.local_map));
    RETURN_IF_ERROR(ValidateAny("loop edge's other end", edge.b));
    const Similarity3d& b_from_a = edge.b_from_a;
    const bool good = std::isfinite(b_from_a.scale) && b_from_a.scale > 0 &&
                      IsPose({b_from_a.rotation, b_from_a.translation});
    if (!good || edge.a == edge.b) return BadValue("loop edge from", edge.a, "similarity or end");
  }
  return absl::OkStatus();
}

absl::Status ValidateFrames(const MapUpdateBatch& batch) {
  for (const TrackedFrame& frame : batch.tracked_frames) {
    RETURN_IF_ERROR(ValidateAny("reference of a tracked frame", frame.reference));
    if (!IsPose(frame.reference_from_camera)) {
      return BadValue("tracked frame of", frame.reference, "pose");
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ValidateName(const std::string& what, const std::string& name) {
  constexpr size_t kMaxLength = 128;
  const bool good = !name.empty() && name.size() <= kMaxLength &&
                    std::all_of(name.begin(), name.end(), [](char c) {
                      const auto u = static_cast<unsigned char>(c);
                      return absl::ascii_isalnum(u) || c == '.' || c == '_' || c == '-';
                    });
  if (good) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("name of the ", what, " must be 1 to ", kMaxLength,
                                                 " of [a-zA-Z0-9._-]; this one has ", name.size(),
                                                 " characters"));
}

absl::Status ValidateBatch(const LocalMapState* local_map, const MapUpdateBatch& batch,
                           const MapStoreOptions& options) {
  if (!batch.local_map.IsValid()) return absl::InvalidArgumentError("batch names no local map");
  RETURN_IF_ERROR(ValidateCount(batch, options));
  RETURN_IF_ERROR(ValidateCameras(local_map, batch));
  RETURN_IF_ERROR(ValidateKeyframes(local_map, batch, options));
  RETURN_IF_ERROR(ValidatePoints(batch));
  RETURN_IF_ERROR(ValidateObservations(local_map, batch, options));
  RETURN_IF_ERROR(ValidateLoopEdges(batch));
  return ValidateFrames(batch);
}

}  // namespace corbslam::map_store
