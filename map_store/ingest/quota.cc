#include "map_store/ingest/quota.h"

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

absl::Status Check(absl::string_view whose, uint64_t stored, uint64_t more, uint64_t limit,
                   LocalMapId local_map, uint64_t number) {
  if (stored <= limit && more <= limit - stored) return absl::OkStatus();
  return absl::ResourceExhaustedError(absl::StrCat(whose, " has ", stored, " bytes; batch ", number,
                                                   " of local map ", ToString(local_map), " has ",
                                                   more, " more; the limit is ", limit));
}

}  // namespace

uint64_t PayloadBytes(const KeyframePayload& payload) {
  return payload.features.keypoints.size() * sizeof(Keypoint) +
         payload.features.descriptors.size() * sizeof(Descriptor);
}

uint64_t StoredBytes(const MapUpdateBatch& batch) {
  uint64_t bytes = batch.cameras.size() * sizeof(Camera);
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    // The batch is not validated yet.
    if (keyframe.payload == nullptr) continue;
    bytes += sizeof(Keyframe) + PayloadBytes(*keyframe.payload);
  }
  bytes += batch.full_points.size() * sizeof(MapPoint);
  bytes += batch.replacements.size() * sizeof(PointReplacement);
  bytes += batch.observations.size() * sizeof(ObservationChange);
  bytes += batch.removed_points.size() * sizeof(MapPointId);
  bytes += batch.removed_keyframes.size() * sizeof(KeyframeRemoval);
  bytes += batch.loop_edges.size() * sizeof(LoopEdge);
  bytes += batch.tracked_frames.size() * sizeof(TrackedFrame);
  bytes += batch.lost_frames_ns.size() * sizeof(int64_t);
  return bytes;
}

uint64_t StoredBytes(const LocalisedFrames& part) {
  return sizeof(part) + part.tracked_frames.size() * sizeof(TrackedFrame) +
         part.lost_frames_ns.size() * sizeof(int64_t);
}

absl::Status CheckQuota(const MissionState& state, const std::string& agent,
                        const MapUpdateBatch& batch, const MapStoreOptions& options) {
  uint64_t of_agent = 0;
  uint64_t of_mission = 0;
  for (const auto& [id, local_map] : state.local_maps) {
    of_mission += local_map.stored_bytes;
    if (local_map.agent == agent) of_agent += local_map.stored_bytes;
  }
  const uint64_t more = StoredBytes(batch);
  RETURN_IF_ERROR(Check(absl::StrCat("agent ", agent), of_agent, more, options.max_bytes_per_agent,
                        batch.local_map, batch.number));
  return Check(absl::StrCat("mission ", state.name), of_mission, more,
               options.max_bytes_per_mission, batch.local_map, batch.number);
}

}  // namespace corbslam::map_store
