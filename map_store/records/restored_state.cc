#include "map_store/records/restored_state.h"

#include "absl/strings/str_cat.h"
#include "map_store/ingest/batch_validation.h"
#include "map_store/ingest/item_validation.h"
#include "map_store/ingest/mission_limits.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

absl::Status ValidateAmount(absl::string_view what, uint64_t amount, uint64_t limit) {
  if (amount <= limit) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("the mission has ", amount, " ", what, "; the limit is ", limit));
}

absl::Status ValidateAmounts(const MissionState& state, const MapStoreOptions& options) {
  RETURN_IF_ERROR(ValidateAmount("agents", state.agents.size(), options.max_agents_per_mission));
  RETURN_IF_ERROR(CheckLocalMaps(state, options));
  uint64_t bytes = 0;
  for (const auto& [id, local_map] : state.local_maps) {
    bytes += local_map.stored_bytes;
    RETURN_IF_ERROR(ValidateAmount(absl::StrCat("cameras in local map ", ToString(id)),
                                   local_map.cameras.size(), options.max_cameras_per_local_map));
    RETURN_IF_ERROR(ValidateAmount(absl::StrCat("parked references in local map ", ToString(id)),
                                   local_map.CountParked(), options.max_parked_references));
  }
  return ValidateAmount("bytes", bytes, options.max_bytes_per_mission);
}

// Returns the name, if it is one of the local map's, else the local map's id.
LocalMapId OwnNameOf(LocalMapId name, const LocalMapState& local_map) {
  return local_map.IsNamed(name) ? name : local_map.id;
}

absl::Status ValidateKeyframes(const LocalMapState& local_map, const MapStoreOptions& options) {
  for (const auto& camera : local_map.cameras) RETURN_IF_ERROR(Validate(*camera));
  for (const auto& recorded : local_map.recorded_cameras) {
    if (recorded.has_value()) RETURN_IF_ERROR(Validate(*recorded));
  }
  for (const auto& [id, keyframe] : local_map.map.keyframes()) {
    RETURN_IF_ERROR(ValidateOwn("keyframe", id, OwnNameOf(id.local_map, local_map)));
    RETURN_IF_ERROR(ValidateFullKeyframe({keyframe.payload, keyframe.camera_from_map, {}},
                                         keyframe.camera(), options));
  }
  for (const auto& [id, tombstone] : local_map.removed_keyframes) {
    RETURN_IF_ERROR(
        ValidatePose("removed keyframe", id, "parent_from_removed", tombstone.parent_from_removed));
  }
  return absl::OkStatus();
}

absl::Status ValidatePoints(const LocalMapState& local_map) {
  for (const auto& [id, point] : local_map.map.points()) {
    RETURN_IF_ERROR(ValidateOwn("map point", id, OwnNameOf(id.local_map, local_map)));
    RETURN_IF_ERROR(ValidatePosition("map point", id, "position", point.position_in_map));
  }
  return absl::OkStatus();
}

absl::Status ValidateFrames(const LocalMapState& local_map) {
  for (const TrackedFrame& frame : local_map.frames) {
    RETURN_IF_ERROR(ValidateTime("tracked frame", frame.timestamp_ns));
    RETURN_IF_ERROR(ValidatePose("tracked frame of", frame.reference, "reference_from_camera",
                                 frame.reference_from_camera));
  }
  for (const int64_t time_ns : local_map.lost_frames_ns) {
    RETURN_IF_ERROR(ValidateTime("lost frame", time_ns));
  }
  return absl::OkStatus();
}

absl::Status ValidateTrack(const std::string& agent, const LocalisedTrack& track) {
  for (const LocalisedRun& run : track.runs) {
    const absl::Status sound = ValidateLocalised({.frames = {},
                                                  .run = run.id,
                                                  .number = run.last_number,
                                                  .recorded_camera = run.recorded_camera,
                                                  .tracked_frames = run.frames,
                                                  .lost_frames_ns = run.lost_frames_ns});
    if (!sound.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("where agent ", agent, " localised: ", sound.message()));
    }
  }
  return absl::OkStatus();
}

absl::Status ValidateGlobal(const GlobalLayer& global) {
  for (const auto& [id, placed] : global.keyframes) {
    RETURN_IF_ERROR(ValidateSimilarity("placed keyframe", id, placed.camera_from_island));
    RETURN_IF_ERROR(
        ValidatePose("placed keyframe", id, "camera_from_local", placed.camera_from_local));
  }
  for (const auto& [id, placed] : global.points) {
    RETURN_IF_ERROR(ValidatePosition("placed point", id, "position", placed.position_in_anchor));
  }
  for (const auto& [id, island_from_local] : global.island_from_local) {
    RETURN_IF_ERROR(ValidateSimilarity("local map of", KeyframeId{id, 0}, island_from_local));
  }
  for (const auto& [id, entry] : global.overlaps.entries()) {
    RETURN_IF_ERROR(
        ValidateSimilarity("overlap of", entry.overlap.query, entry.overlap.candidate_from_query));
    if (!IsCovariance(entry.overlap.covariance)) {
      return absl::InvalidArgumentError(absl::StrCat("overlap of ", ToString(entry.overlap.query),
                                                     " has a covariance that is none"));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ValidateRestored(const MissionState& state, const MapStoreOptions& options) {
  RETURN_IF_ERROR(ValidateAmounts(state, options));
  for (const auto& [name, agent] : state.agents) {
    RETURN_IF_ERROR(ValidateName("agent", name));
    RETURN_IF_ERROR(ValidateTrack(name, agent.track));
  }
  for (const auto& [id, local_map] : state.local_maps) {
    RETURN_IF_ERROR(ValidateKeyframes(local_map, options));
    RETURN_IF_ERROR(ValidatePoints(local_map));
    RETURN_IF_ERROR(ValidateFrames(local_map));
  }
  return ValidateGlobal(state.global);
}

}  // namespace corbslam::map_store
