#include "map_store/store/journal_copy.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "map_store/archive/feature_archive.h"
#include "map_store/archive/state_archive.h"
#include "map_store/mission/mission_strand.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

absl::StatusOr<MissionState> ReadState(Journal& journal, const std::string& mission) {
  const MapStoreOptions options = MapStoreOptions::WithoutBatchLimits();
  MissionEnvironment environment;
  environment.options = &options;
  environment.journal = &journal;
  environment.clock = &absl::Now;
  environment.wake_fusion = [] {};
  MissionStrand strand(mission, std::move(environment));
  RETURN_IF_ERROR(strand.Recover());
  StateWriteLock lock(strand);
  return std::move(strand.mutable_state());
}

// Returns DATA_LOSS, naming the first thing that is not the same.
absl::Status Compare(const MissionState& original, const MissionState& copy) {
  for (const auto& [id, local_map] : original.local_maps) {
    const LocalMapState* other = copy.FindLocalMap(id);
    if (other == nullptr) {
      return absl::DataLossError(absl::StrCat("local map ", ToString(id), " is not in the copy"));
    }
    for (const auto& [keyframe_id, keyframe] : local_map.map.keyframes()) {
      const Keyframe* copied = other->map.FindKeyframe(keyframe_id);
      if (copied == nullptr) {
        return absl::DataLossError(
            absl::StrCat("keyframe ", ToString(keyframe_id), " is not in the copy"));
      }
      if (EncodeFeatures(*keyframe.payload) != EncodeFeatures(*copied->payload)) {
        return absl::DataLossError(
            absl::StrCat("keyframe ", ToString(keyframe_id), " has other features in the copy"));
      }
    }
  }
  if (EncodeState(original) == EncodeState(copy)) return absl::OkStatus();
  return absl::DataLossError("the copy is not like it");
}

absl::Status ComparePicture(const Journal& to, const std::string& mission,
                            const KeyframePicture& picture) {
  ASSIGN_OR_RETURN(const KeyframePicture copied, to.ReadPicture(mission, picture.keyframe));
  if (copied.jpeg == picture.jpeg && copied.scale == picture.scale) return absl::OkStatus();
  return absl::DataLossError(
      absl::StrCat("the picture of keyframe ", ToString(picture.keyframe), " is another one"));
}

absl::Status CopyPictures(const Journal& from, Journal& to, CopiedMission& mission) {
  return from.ForEachPicture(mission.name, [&](const KeyframePicture& picture) -> absl::Status {
    RETURN_IF_ERROR(to.PutPicture(mission.name, picture, std::numeric_limits<uint64_t>::max()));
    ++mission.pictures;
    return ComparePicture(to, mission.name, picture);
  });
}

void Count(const MissionState& state, CopiedMission& mission) {
  mission.agents = state.agents.size();
  mission.local_maps = state.local_maps.size();
  for (const auto& [id, local_map] : state.local_maps) {
    mission.keyframes += local_map.map.keyframes().size();
  }
}

absl::Status CopyMission(Journal& from, Journal& to, bool is_there, CopiedMission& mission) {
  ASSIGN_OR_RETURN(const MissionState original, ReadState(from, mission.name));
  Count(original, mission);
  if (is_there) {
    ASSIGN_OR_RETURN(const MissionState there, ReadState(to, mission.name));
    if (!Compare(original, there).ok()) {
      return absl::AlreadyExistsError("there is another mission of that name");
    }
    mission.was_there = true;
    return CopyPictures(from, to, mission);
  }
  RETURN_IF_ERROR(to.CreateMission(mission.name, original));
  // What was written is read again, whatever was told of it.
  absl::StatusOr<MissionState> copy = ReadState(to, mission.name);
  absl::Status same = copy.ok() ? Compare(original, *copy) : copy.status();
  if (same.ok()) same = CopyPictures(from, to, mission);
  if (!same.ok()) to.DeleteMission(mission.name).IgnoreError();
  return same;
}

absl::Status CopyList(MissionList list, const Journal& from, Journal& to) {
  const std::vector<MissionIdentity> there = to.ReadList(list);
  for (const MissionIdentity& mission : from.ReadList(list)) {
    if (std::find(there.begin(), there.end(), mission) != there.end()) continue;
    RETURN_IF_ERROR(to.NoteInList(list, mission));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CopyJournal(Journal& from, Journal& to,
                         const std::function<void(const CopiedMission& mission)>& tell) {
  ASSIGN_OR_RETURN(const std::vector<std::string> names, from.ListMissions());
  ASSIGN_OR_RETURN(const std::vector<std::string> there, to.ListMissions());
  for (const MissionList list : {MissionList::kDeleted, MissionList::kPromised}) {
    RETURN_IF_ERROR(CopyList(list, from, to));
  }
  for (const std::string& name : names) {
    CopiedMission mission;
    mission.name = name;
    const bool is_there = std::find(there.begin(), there.end(), name) != there.end();
    mission.status = CopyMission(from, to, is_there, mission);
    tell(mission);
  }
  return absl::OkStatus();
}

}  // namespace corbslam::map_store
