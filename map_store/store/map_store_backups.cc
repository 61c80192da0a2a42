// Implements the part of MapStore that backups on a shelf need (stored_backups.h).
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/ingest/batch_validation.h"
#include "map_store/process/memory_budget.h"
#include "map_store/process/mission.h"
#include "map_store/process/mission_directory.h"
#include "map_store/store/map_store.h"
#include "map_store/view/damage_text.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

absl::Status MapStore::CheckRoomToRestore(const std::string& name, uint64_t bytes) const {
  RETURN_IF_ERROR(map_store::ValidateName("mission", name));
  if (bytes > options_.max_backup_bytes) {
    return absl::ResourceExhaustedError(
        absl::StrCat("the backup has ", bytes, " bytes; the limit is ", options_.max_backup_bytes));
  }
  if (const auto known = directory_->Peek(name); known.ok()) {
    if (!known->damage.ok()) return absl::DataLossError(SayDamage(name, known->damage));
    return absl::AlreadyExistsError(absl::StrCat("there is a mission ", name, " already"));
  }
  RETURN_IF_ERROR(CheckRoomForMission());
  // Coded features take about half of what they take in memory.
  return memory_->Check("a stored backup", 3 * bytes);
}

absl::Status MapStore::CheckNobodyConnected(absl::string_view name) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(name));
  return CheckNoSession(name, *mission);
}

absl::Status MapStore::CheckNoSession(absl::string_view name, const Mission& mission) const {
  absl::MutexLock lock(&mutex_);
  for (const auto& [id, session] : sessions_) {
    if (session.mission.get() != &mission) continue;
    return absl::FailedPreconditionError(absl::StrCat("agent ", session.agent,
                                                      " is connected to mission ", name,
                                                      ": stop it, and the others, first"));
  }
  return absl::OkStatus();
}

absl::Status MapStore::DeleteUnusedMission(absl::string_view name,
                                           const std::function<absl::Status()>& may) {
  absl::MutexLock deleting(&deletion_mutex_);
  RETURN_IF_ERROR(CheckNobodyConnected(name));
  ASSIGN_OR_RETURN(const MissionDirectory::Life life, directory_->FindLife(name));
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission,
                   directory_->BeginDeletion(name, life, "it was archived"));
  // A robot that came before is connected now, or finds the mission closed once it is.
  absl::Status deleted =
      absl::FailedPreconditionError(absl::StrCat("mission ", name, " is asleep"));
  if (mission != nullptr) deleted = CheckNoSession(name, *mission);
  // From here on nothing is appended to the journal, so that what is deleted stays deleted.
  if (deleted.ok()) deleted = mission->DeleteIf(may);
  if (!deleted.ok()) directory_->EndDeletion(name, false);
  RETURN_IF_ERROR(deleted);
  return EndLife(name, mission);
}

absl::StatusOr<std::shared_ptr<const void>> MapStore::HoldAwake(absl::string_view name) const {
  return AwaitMission(name);
}

}  // namespace corbslam::map_store
