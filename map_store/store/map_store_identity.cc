// Implements the part of MapStore that tells missions of one name apart.
#include <glog/logging.h>

#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/process/departed_missions.h"
#include "map_store/process/mission.h"
#include "map_store/process/mission_directory.h"
#include "map_store/process/promised_uids.h"
#include "map_store/state/mission_uid.h"
#include "map_store/store/map_store.h"
#include "slam/exchange/session_end.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Returns the uid of a mission; empty: nobody knows it, as the mission can't be read.
std::string UidOf(const KnownMission& known) {
  if (known.mission != nullptr) return known.mission->uid();
  return known.evicted != nullptr ? known.evicted->summary.info.uid : "";
}

DepartedMissions::Processes ProcessesOf(const Mission& mission) {
  return mission.WithState([](const MissionState& state) {
    DepartedMissions::Processes processes;
    for (const auto& [name, agent] : state.agents) processes[name] = agent.instance;
    return processes;
  });
}

}  // namespace

absl::Status MapStore::CheckNotDeparted(const SessionRequest& request) const {
  std::optional<std::string> present;
  if (const auto known = directory_->Peek(request.mission); known.ok()) present = UidOf(*known);
  bool is_departed = false;
  if (request.mission_uid.empty()) {
    is_departed = departed_->HasProcess(request.mission, present.value_or(""), request.agent,
                                        request.instance);
  } else if (present.has_value()) {
    // A mission that can't be read has its own error.
    is_departed = !present->empty() && *present != request.mission_uid;
  } else {
    // A mission of which nothing was written goes with its last robot, which may come back.
    is_departed = !IsUidOf(request.mission, request.mission_uid) ||
                  departed_->Has(request.mission, request.mission_uid);
  }
  return is_departed ? MissionDeletedError(request.mission) : absl::OkStatus();
}

absl::Status MapStore::CheckUid(absl::string_view name, absl::string_view uid) const {
  if (uid.empty()) return absl::OkStatus();
  ASSIGN_OR_RETURN(const KnownMission known, directory_->Peek(name));
  const std::string present = UidOf(known);
  if (present == uid) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("mission ", name, " has the uid ",
                   present.empty() ? "(not known: it can't be read)" : present, ", and ", uid,
                   " is meant: that one is not there any more, or has another name"));
}

std::string MapStore::UidToBegin(const std::string& name) const {
  const std::string promised = promised_uids_->Find(name);
  const bool still_holds = IsUidOf(name, promised) && !departed_->Has(name, promised);
  return still_holds ? promised : DrawMissionUid(name);
}

void MapStore::NoteDeparture(absl::string_view name) {
  const absl::StatusOr<KnownMission> known = directory_->Peek(name);
  if (!known.ok()) return;
  const MissionIdentity departed{known->name, UidOf(*known)};
  DepartedMissions::Processes processes;
  if (known->mission != nullptr) processes = ProcessesOf(*known->mission);
  departed_->Note(departed, std::move(processes));
  const absl::Status noted = journal_->NoteInList(MissionList::kDeleted, departed);
  LOG_IF(WARNING, !noted.ok()) << "mission " << name << " is deleted, and a robot of it that comes "
                               << "back after the next start will make it anew: " << noted;
  LOG(INFO) << "mission " << name << " with uid "
            << (departed.uid.empty() ? "(not known)" : departed.uid) << " goes";
}

}  // namespace corbslam::map_store
