#include "map_store/archive/stored_map.h"

#include <utility>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "map_store/archive/unreadable.h"
#include "map_store/ingest/item_validation.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Returns the payload with its features, which must be valid; without features if `load` is null.
absl::StatusOr<std::shared_ptr<const KeyframePayload>> WithFeatures(const StoredKeyframe& stored,
                                                                    const LocalMapState& local_map,
                                                                    const FeatureLoader& load) {
  const KeyframeId id = stored.payload->id;
  const uint32_t index = stored.payload->camera_index;
  if (index >= local_map.cameras.size()) {
    return Unreadable(absl::StrCat("camera of keyframe ", ToString(id)));
  }
  const std::shared_ptr<const Camera>& camera = local_map.cameras[index];
  auto payload = std::make_shared<KeyframePayload>(*stored.payload);
  payload->camera = camera;
  if (load == nullptr) return payload;
  ASSIGN_OR_RETURN(payload->features, load(id));
  if (payload->features.keypoints.size() != stored.keypoints) return DifferentCount(id);
  const absl::Status valid = ValidateFullKeyframe({payload, stored.camera_from_map, stored.parent},
                                                  *camera, MapStoreOptions::WithoutBatchLimits());
  if (!valid.ok()) return absl::DataLossError(valid.message());
  return MakeKeyframePayload(std::move(*payload));
}

absl::Status AddKeyframes(const std::vector<StoredKeyframe>& keyframes, const FeatureLoader& load,
                          LocalMapState* local_map) {
  for (const std::shared_ptr<const Camera>& camera : local_map->cameras) {
    if (const absl::Status valid = Validate(*camera); !valid.ok()) {
      return absl::DataLossError(valid.message());
    }
  }
  for (const StoredKeyframe& from : keyframes) {
    Keyframe keyframe;
    ASSIGN_OR_RETURN(keyframe.payload, WithFeatures(from, *local_map, load));
    keyframe.points.resize(from.keypoints);
    keyframe.camera_from_map = from.camera_from_map;
    if (!local_map->map.AddKeyframe(std::move(keyframe))) {
      return Unreadable(absl::StrCat("keyframe ", ToString(from.payload->id)));
    }
  }
  return absl::OkStatus();
}

bool AddEdges(const std::vector<StoredKeyframe>& keyframes, Map* map) {
  bool sound = true;
  for (const StoredKeyframe& keyframe : keyframes) {
    const KeyframeId id = keyframe.payload->id;
    if (keyframe.parent.IsValid()) sound &= map->SetParent(id, keyframe.parent);
    for (const KeyframeId& other : keyframe.loop_edges) {
      // Each edge is stored with both of its keyframes.
      if (id < other) sound &= map->AddLoopEdge(id, other);
    }
  }
  return sound;
}

absl::Status AddPoints(const std::vector<StoredPoint>& points, Map* map) {
  for (const StoredPoint& from : points) {
    const absl::Status valid =
        ValidateFullPoint({from.id, from.position_in_map, from.reference, from.descriptor,
                           from.normal_in_map, from.min_distance, from.max_distance});
    if (!valid.ok()) return absl::DataLossError(valid.message());
    MapPoint point;
    point.id = from.id;
    point.position_in_map = from.position_in_map;
    point.reference = from.reference;
    point.descriptor = from.descriptor;
    point.normal_in_map = from.normal_in_map;
    point.min_distance = from.min_distance;
    point.max_distance = from.max_distance;
    bool sound = map->AddPoint(std::move(point));
    for (const auto& [keyframe, keypoint] : from.observations) {
      sound &= map->AddObservation(from.id, keyframe, keypoint);
    }
    if (!sound) return Unreadable(absl::StrCat("point ", ToString(from.id)));
  }
  return absl::OkStatus();
}

}  // namespace

StoredMap ToStored(const Map& map) {
  StoredMap stored;
  for (const auto& [id, keyframe] : map.keyframes()) {
    stored.keyframes.push_back({keyframe.payload,
                                static_cast<uint32_t>(keyframe.points.size()),
                                keyframe.camera_from_map,
                                keyframe.parent,
                                {keyframe.loop_edges.begin(), keyframe.loop_edges.end()}});
  }
  for (const auto& [id, point] : map.points()) {
    stored.points.push_back({point.id,
                             point.position_in_map,
                             point.reference,
                             point.descriptor,
                             point.normal_in_map,
                             point.min_distance,
                             point.max_distance,
                             {point.observations.begin(), point.observations.end()}});
  }
  return stored;
}

absl::Status BuildMap(const StoredMap& stored, const FeatureLoader& load,
                      LocalMapState* local_map) {
  RETURN_IF_ERROR(AddKeyframes(stored.keyframes, load, local_map));
  if (!AddEdges(stored.keyframes, &local_map->map)) {
    return Unreadable(absl::StrCat("local map ", ToString(local_map->id)));
  }
  RETURN_IF_ERROR(AddPoints(stored.points, &local_map->map));
  for (const auto& [id, point] : local_map->map.points()) {
    local_map->followers.Add(point.reference, id);
  }
  return absl::OkStatus();
}

}  // namespace corbslam::map_store
