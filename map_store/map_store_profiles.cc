// Implements the part of MapStore that makes missions ahead, changes what is set of them, and
// deletes those that nobody uses any more.
#include <glog/logging.h>

#include <algorithm>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/ingest/batch_validation.h"
#include "map_store/map_store.h"
#include "map_store/mission/mission.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

absl::Status MapStore::ReserveName(const std::string& name) {
  absl::MutexLock lock(&mutex_);
  if (missions_.contains(name) || making_.contains(name)) {
    return absl::AlreadyExistsError(absl::StrCat("there is a mission ", name, " already"));
  }
  RETURN_IF_ERROR(CheckReadable(name));
  RETURN_IF_ERROR(CheckRoomForMission());
  making_.insert(name);
  return absl::OkStatus();
}

void MapStore::TakeMade(const std::string& name, std::shared_ptr<Mission> mission) {
  absl::MutexLock lock(&mutex_);
  making_.erase(name);
  if (mission != nullptr) missions_[name] = std::move(mission);
}

absl::Status MapStore::CreateMission(const std::string& name, const MissionProfile& profile) {
  RETURN_IF_ERROR(map_store::ValidateName("mission", name));
  RETURN_IF_ERROR(ValidateProfile(profile));
  RETURN_IF_ERROR(ReserveName(name));
  std::shared_ptr<Mission> mission = MakeMission(name);
  const absl::Status begun = mission->profile().Begin(profile);
  if (!begun.ok()) {
    // What the caller was told is not there must not be there after a restart either.
    const absl::Status removed = journal_->DeleteMission(name);
    LOG_IF(WARNING, !removed.ok()) << "mission " << name << " was not made, but may be there after "
                                   << "the next start: " << removed;
    mission.reset();
  }
  TakeMade(name, std::move(mission));
  return begun;
}

absl::Status MapStore::UpdateMission(absl::string_view mission_name, const MissionProfile& values,
                                     const std::vector<ProfileField>& fields) {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->profile().Update(values, fields);
}

absl::Duration MapStore::PaceUplink(uint64_t session_id, uint64_t bytes) {
  const absl::StatusOr<Session> session = FindSession(session_id);
  if (!session.ok()) return absl::ZeroDuration();
  return session->mission->profile().PaceUplink(session->agent, bytes);
}

void MapStore::SetExpiryListener(ExpiryListener listener) {
  absl::MutexLock lock(&mutex_);
  expiry_listener_ = std::move(listener);
}

bool MapStore::IsOccupied(const Mission& mission) const {
  return mission.IsWatched() ||
         std::any_of(sessions_.begin(), sessions_.end(), [&mission](const auto& session) {
           return session.second.mission.get() == &mission;
         });
}

void MapStore::TendMissions() {
  std::vector<std::pair<std::string, std::shared_ptr<Mission>>> missions;
  std::set<const Mission*> occupied;
  {
    absl::MutexLock lock(&mutex_);
    missions.assign(missions_.begin(), missions_.end());
    for (const auto& [id, session] : sessions_) occupied.insert(session.mission.get());
  }
  for (const auto& [name, mission] : missions) {
    if (occupied.contains(mission.get()) || mission->IsWatched()) mission->profile().NoteUse();
    // The journal itself says what is wrong with it; the next time is soon enough.
    mission->profile().KeepUse().IgnoreError();
    if (mission->profile().IsOutdated()) Expire(name, mission);
  }
}

void MapStore::Expire(const std::string& name, const std::shared_ptr<Mission>& mission) {
  // What is damaged is for people to look at first.
  if (!journal_->Damage(name).ok()) return;
  ExpiryListener listener;
  absl::Status deleted;
  {
    absl::MutexLock deleting(&deletion_mutex_);
    {
      absl::MutexLock lock(&mutex_);
      const auto it = missions_.find(name);
      // A robot may have come since; from here on none can.
      const bool is_due = it != missions_.end() && it->second == mission && !IsOccupied(*mission) &&
                          mission->profile().IsOutdated();
      if (!is_due) return;
      expiring_.insert(name);
      listener = expiry_listener_;
    }
    deleted = Forget(name, mission);
    absl::MutexLock lock(&mutex_);
    expiring_.erase(name);
  }
  const MissionProfile profile = mission->profile().Get();
  const std::string why =
      absl::StrCat("nobody has used it since ",
                   absl::FormatTime("%Y-%m-%dT%H:%M:%SZ", absl::FromUnixNanos(profile.last_used_ns),
                                    absl::UTCTimeZone()),
                   ", its retention is ", profile.retention_s, " s");
  LOG_IF(WARNING, !deleted.ok()) << "mission " << name << " is to be deleted, as " << why
                                 << ", and could not be: " << deleted;
  if (!deleted.ok()) return;
  LOG(INFO) << "mission " << name << " deleted: " << why;
  if (listener != nullptr) listener(name, why);
}

}  // namespace corbslam::map_store
