#include "map_store/ingest/batch_validation.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <set>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "map_store/ingest/batch_cost.h"
#include "map_store/ingest/item_validation.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

absl::Status ValidateAmount(const MapUpdateBatch& batch, absl::string_view what, size_t amount,
                            size_t limit) {
  if (amount <= limit) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("batch ", batch.number, " has ", amount, " ", what, "; the limit is ", limit));
}

absl::Status ValidateCount(const MapUpdateBatch& batch, const MapStoreOptions& options) {
  const size_t items = batch.cameras.size() + batch.full_keyframes.size() +
                       batch.full_points.size() + batch.light_keyframes.size() +
                       batch.light_points.size() + batch.replacements.size() +
                       batch.observations.size() + batch.removed_points.size() +
                       batch.removed_keyframes.size() + batch.loop_edges.size();
  const size_t frames = batch.tracked_frames.size() + batch.lost_frames_ns.size();
  RETURN_IF_ERROR(ValidateAmount(batch, "items", items, options.max_items_per_batch));
  return ValidateAmount(batch, "frames", frames, options.max_frames_per_batch);
}

absl::Status ValidateRecordedCameras(const LocalMapState* local_map, const MapUpdateBatch& batch) {
  if (batch.recorded_cameras.empty()) return absl::OkStatus();
  if (batch.recorded_cameras.size() != batch.cameras.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("recorded_cameras has ", batch.recorded_cameras.size(), " entries, cameras ",
                     batch.cameras.size(), "; must be as many or none"));
  }
  for (size_t i = 0; i < batch.recorded_cameras.size(); ++i) {
    const size_t index = batch.first_camera_index + i;
    RETURN_IF_ERROR(Validate(batch.recorded_cameras[i]));
    if (local_map == nullptr || index >= local_map->cameras.size()) continue;
    if (local_map->Recorded(index) == batch.recorded_cameras[i]) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("recorded camera ", index, " differs from what was sent before"));
  }
  return absl::OkStatus();
}

absl::Status ValidateCameras(const LocalMapState* local_map, const MapUpdateBatch& batch,
                             const MapStoreOptions& options) {
  const size_t known = local_map == nullptr ? 0 : local_map->cameras.size();
  RETURN_IF_ERROR(ValidateRecordedCameras(local_map, batch));
  if (batch.cameras.empty()) return absl::OkStatus();
  if (batch.first_camera_index > known ||
      batch.first_camera_index + batch.cameras.size() > options.max_cameras_per_local_map) {
    return absl::InvalidArgumentError(absl::StrCat("cameras from index ", batch.first_camera_index,
                                                   ": ", known, " are known, the limit is ",
                                                   options.max_cameras_per_local_map));
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

absl::Status ValidateKeyframes(const LocalMapState* local_map, const MapUpdateBatch& batch,
                               const MapStoreOptions& options) {
  std::set<KeyframeId> seen;
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    if (keyframe.payload == nullptr) {
      return absl::InvalidArgumentError("full keyframe without payload");
    }
    const KeyframeId id = keyframe.payload->id;
    const uint32_t index = keyframe.payload->camera_index;
    RETURN_IF_ERROR(ValidateOwn("full keyframe", id, batch.local_map));
    RETURN_IF_ERROR(ValidateOnce("full keyframe", id, seen));
    const Camera* camera = FindCamera(local_map, batch, index);
    if (camera == nullptr) {
      return absl::InvalidArgumentError(
          absl::StrCat("keyframe ", ToString(id), ": camera ", index, " was never sent"));
    }
    RETURN_IF_ERROR(ValidateFullKeyframe(keyframe, *camera, options));
  }
  seen.clear();
  for (const LightKeyframe& keyframe : batch.light_keyframes) {
    RETURN_IF_ERROR(ValidateOwn("light keyframe", keyframe.id, batch.local_map));
    RETURN_IF_ERROR(ValidateLightKeyframe(keyframe));
  }
  for (const KeyframeRemoval& removal : batch.removed_keyframes) {
    RETURN_IF_ERROR(ValidateOwn("removed keyframe", removal.id, batch.local_map));
    RETURN_IF_ERROR(ValidateOnce("removed keyframe", removal.id, seen));
    RETURN_IF_ERROR(ValidateRemoval(removal));
  }
  return absl::OkStatus();
}

absl::Status ValidatePoints(const MapUpdateBatch& batch) {
  std::set<MapPointId> seen;
  for (const FullMapPoint& point : batch.full_points) {
    RETURN_IF_ERROR(ValidateOwn("full map point", point.id, batch.local_map));
    RETURN_IF_ERROR(ValidateOnce("full map point", point.id, seen));
    RETURN_IF_ERROR(ValidateFullPoint(point));
  }
  for (const LightMapPoint& point : batch.light_points) {
    RETURN_IF_ERROR(ValidateOwn("light map point", point.id, batch.local_map));
    RETURN_IF_ERROR(
        ValidatePosition("light map point", point.id, "position", point.position_in_local));
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

// Says whether what a batch refers to is there already, or comes with the batch.
class References {
 public:
  References(const LocalMapState* local_map, const MapUpdateBatch& batch) : local_map_(local_map) {
    for (const FullKeyframe& keyframe : batch.full_keyframes) {
      keypoints_[keyframe.payload->id] = keyframe.payload->features.keypoints.size();
    }
    for (const FullMapPoint& point : batch.full_points) points_.insert(point.id);
  }

  // Returns the number of the keyframe's keypoints; none if the keyframe is unknown.
  std::optional<size_t> CountKeypoints(KeyframeId id) const {
    // A keyframe that is known already is not taken again.
    if (const Keyframe* known =
            local_map_ == nullptr ? nullptr : local_map_->map.FindKeyframe(id)) {
      return known->points.size();
    }
    const auto it = keypoints_.find(id);
    if (it == keypoints_.end()) return std::nullopt;
    return it->second;
  }
  // A removed keyframe counts as there: it is remembered, so that a reference to it does not wait.
  bool HasKeyframe(KeyframeId id) const {
    return CountKeypoints(id).has_value() ||
           (local_map_ != nullptr && local_map_->removed_keyframes.contains(id));
  }
  bool HasPoint(MapPointId id) const {
    if (points_.contains(id)) return true;
    return local_map_ != nullptr &&
           (local_map_->map.FindPoint(id) || local_map_->removed_points.contains(id) ||
            local_map_->replaced_points.contains(id));
  }

 private:
  const LocalMapState* const local_map_;
  std::map<KeyframeId, size_t> keypoints_;
  std::set<MapPointId> points_;
};

absl::Status ValidateObservations(const References& references, const MapUpdateBatch& batch,
                                  const MapStoreOptions& options) {
  for (const ObservationChange& change : batch.observations) {
    RETURN_IF_ERROR(ValidateOwn("observing keyframe", change.keyframe, batch.local_map));
    RETURN_IF_ERROR(ValidateAny("observed point", change.point));
    const bool is_added = change.kind == ObservationChange::Kind::kAdded;
    if (!is_added && change.kind != ObservationChange::Kind::kRemoved) {
      return absl::InvalidArgumentError(
          absl::StrCat("observation of ", ToString(change.point), " by keyframe ",
                       ToString(change.keyframe), " is of kind ", static_cast<int>(change.kind)));
    }
    const size_t limit =
        references.CountKeypoints(change.keyframe).value_or(options.max_keypoints_per_keyframe);
    if (is_added && change.keypoint >= limit) {
      return absl::InvalidArgumentError(
          absl::StrCat("observation of ", ToString(change.point), " by keypoint ", change.keypoint,
                       " of keyframe ", ToString(change.keyframe), ", which has ", limit));
    }
  }
  return absl::OkStatus();
}

absl::Status ValidateLoopEdges(const MapUpdateBatch& batch) {
  for (const LoopEdge& edge : batch.loop_edges) {
    RETURN_IF_ERROR(ValidateOwn("loop edge from", edge.a, batch.local_map));
    RETURN_IF_ERROR(ValidateAny("loop edge's other end", edge.b));
    if (edge.a == edge.b) {
      return absl::InvalidArgumentError(
          absl::StrCat("loop edge from ", ToString(edge.a), " to itself"));
    }
    RETURN_IF_ERROR(ValidateSimilarity("loop edge from", edge.a, edge.b_from_a));
  }
  return absl::OkStatus();
}

absl::Status ValidateFrames(const std::vector<TrackedFrame>& tracked_frames,
                            const std::vector<int64_t>& lost_frames_ns) {
  for (const TrackedFrame& frame : tracked_frames) {
    RETURN_IF_ERROR(ValidateAny("reference of a tracked frame", frame.reference));
    RETURN_IF_ERROR(ValidateTime("tracked frame", frame.timestamp_ns));
    RETURN_IF_ERROR(ValidatePose("tracked frame of", frame.reference, "reference_from_camera",
                                 frame.reference_from_camera));
  }
  for (const int64_t time_ns : lost_frames_ns) {
    RETURN_IF_ERROR(ValidateTime("lost frame", time_ns));
  }
  return absl::OkStatus();
}

// Checks that what the batch would park is not too much, together with what is parked already.
absl::Status ValidateParked(const LocalMapState* local_map, const References& references,
                            const MapUpdateBatch& batch, const MapStoreOptions& options) {
  size_t parked = local_map == nullptr ? 0 : local_map->CountParked();
  const auto count = [&](bool is_there) { parked += is_there ? 0 : 1; };
  const auto has_own = [&](KeyframeId id) {
    return !id.IsValid() || id.local_map != batch.local_map || references.HasKeyframe(id);
  };
  for (const ObservationChange& change : batch.observations) {
    count(references.HasKeyframe(change.keyframe) &&
          (change.point.local_map != batch.local_map || references.HasPoint(change.point)));
  }
  for (const LoopEdge& edge : batch.loop_edges) count(has_own(edge.a) && has_own(edge.b));
  for (const FullKeyframe& keyframe : batch.full_keyframes) count(has_own(keyframe.parent));
  for (const LightKeyframe& keyframe : batch.light_keyframes) count(has_own(keyframe.parent));
  if (parked <= options.max_parked_references) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat(parked, " references of local map ", ToString(batch.local_map),
                   " to what has not arrived; the limit is ", options.max_parked_references));
}

// Checks that each light item comes once only. The size of a move does not tell its cost: it may
// move a chain of keyframes, and the points that follow them.
absl::Status ValidateLightItemsOnce(const MapUpdateBatch& batch) {
  std::set<KeyframeId> keyframes;
  for (const LightKeyframe& keyframe : batch.light_keyframes) {
    RETURN_IF_ERROR(ValidateOnce("light keyframe", keyframe.id, keyframes));
  }
  std::set<MapPointId> points;
  for (const LightMapPoint& point : batch.light_points) {
    RETURN_IF_ERROR(ValidateOnce("light map point", point.id, points));
  }
  return absl::OkStatus();
}

absl::Status ValidateValues(const LocalMapState* local_map, const MapUpdateBatch& batch,
                            const MapStoreOptions& options) {
  if (!batch.local_map.IsValid()) return absl::InvalidArgumentError("batch names no local map");
  RETURN_IF_ERROR(ValidateCount(batch, options));
  RETURN_IF_ERROR(ValidateCameras(local_map, batch, options));
  RETURN_IF_ERROR(ValidateKeyframes(local_map, batch, options));
  RETURN_IF_ERROR(ValidatePoints(batch));
  const References references(local_map, batch);
  RETURN_IF_ERROR(ValidateObservations(references, batch, options));
  RETURN_IF_ERROR(ValidateLoopEdges(batch));
  RETURN_IF_ERROR(ValidateFrames(batch.tracked_frames, batch.lost_frames_ns));
  return ValidateParked(local_map, references, batch, options);
}

}  // namespace

absl::Status ValidateLocalised(const LocalisedFrames& part) {
  if (part.run == 0 || part.number == 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("run is ", part.run, " and number ", part.number, ", both must be 1 or more"));
  }
  if (part.recorded_camera.has_value()) RETURN_IF_ERROR(Validate(*part.recorded_camera));
  return ValidateFrames(part.tracked_frames, part.lost_frames_ns);
}

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
  RETURN_IF_ERROR(ValidateValues(local_map, batch, options));
  RETURN_IF_ERROR(ValidateLightItemsOnce(batch));
  return ValidateCost(local_map, batch, options);
}

absl::Status ValidateRecordedBatch(const LocalMapState* local_map, const MapUpdateBatch& batch) {
  return ValidateValues(local_map, batch, MapStoreOptions::WithoutBatchLimits());
}

}  // namespace corbslam::map_store
