#include "map_store/mission/picture_intake.h"

#include <glog/logging.h>

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "map_store/ingest/picture_validation.h"
#include "map_store/mission/mission_sessions.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

constexpr uint64_t kShareOfDisk = 8;

}  // namespace

absl::Status PictureIntake::Check(uint64_t session_id, const std::string& agent,
                                  KeyframeId keyframe, bool& is_there) const {
  absl::ReaderMutexLock lock(&strand_.mutex());
  RETURN_IF_ERROR(CheckSession(strand_, session_id, agent));
  const MissionState& state = strand_.state();
  if (state.agents.at(agent).localise_only) {
    return absl::PermissionDeniedError(
        absl::StrCat("agent ", agent,
                     " opened its session with localise_only, which changes nothing: it may not "
                     "send pictures of keyframes"));
  }
  const LocalMapState* const local_map = state.FindLocalMap(keyframe.local_map);
  if (local_map != nullptr && local_map->agent != agent) {
    return absl::PermissionDeniedError(absl::StrCat("picture of keyframe ", ToString(keyframe),
                                                    ": its local map is another "
                                                    "agent's"));
  }
  is_there = local_map != nullptr && local_map->map.FindKeyframe(keyframe) != nullptr;
  return absl::OkStatus();
}

uint64_t PictureIntake::MaxBytes() const {
  const uint64_t most = strand_.options().max_picture_bytes_per_mission;
  const uint64_t disk_bytes =
      strand_.WithState([](const MissionState& state) { return state.profile.limits.disk_bytes; });
  return disk_bytes == 0 ? most : std::min(most, disk_bytes / kShareOfDisk);
}

absl::Status PictureIntake::Keep(uint64_t session_id, const std::string& agent,
                                 const KeyframePicture& picture) {
  RETURN_IF_ERROR(ValidatePicture(picture));
  bool is_there = false;
  RETURN_IF_ERROR(Check(session_id, agent, picture.keyframe, is_there));
  const uint64_t max_bytes = MaxBytes();
  if (!is_there || max_bytes == 0) return absl::OkStatus();
  const absl::Status kept =
      strand_.environment().journal->PutPicture(strand_.name(), picture, max_bytes);
  LOG_IF_EVERY_N(WARNING, !kept.ok(), 1000)
      << "mission " << strand_.name() << " keeps no pictures of keyframes for now: " << kept;
  return absl::OkStatus();
}

}  // namespace corbslam::map_store
