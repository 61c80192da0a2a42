// Implements the part of MapStore that makes missions ahead, changes what is set of them, and
// deletes those that nobody uses any more.
#include <glog/logging.h>

#include <limits>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/ingest/batch_validation.h"
#include "map_store/process/mission.h"
#include "map_store/process/mission_directory.h"
#include "map_store/records/mission_leases.h"
#include "map_store/store/map_store.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Missions that are asleep in a shared journal are looked at once in so many times.
constexpr int kTendingsToAsleep = 10;
constexpr size_t kListedAtOnce = 200;

MissionProfile ProfileOf(const KnownMission& known) {
  if (known.mission != nullptr) return known.mission->profile().Get();
  return known.evicted != nullptr ? known.evicted->summary.info.profile : MissionProfile();
}

// Returns whether the mission's retention has passed.
bool IsOutdated(const KnownMission& known, absl::Time now) {
  if (known.mission != nullptr) {
    return !known.mission->IsWatched() && known.mission->profile().IsOutdated();
  }
  const MissionProfile profile = ProfileOf(known);
  if (profile.retention_s == 0 || profile.last_used_ns == 0) return false;
  const absl::Duration unused = now - absl::FromUnixNanos(profile.last_used_ns);
  // Before it fell asleep the store may have been killed, and known of its last use too little.
  return unused >= absl::Seconds(profile.retention_s) + ProfileKeeper::kBetweenUses;
}

}  // namespace

absl::Status MapStore::CreateMission(const std::string& name, const MissionProfile& profile) {
  RETURN_IF_ERROR(map_store::ValidateName("mission", name));
  RETURN_IF_ERROR(ValidateProfile(profile));
  RETURN_IF_ERROR(ReserveName(name));
  std::shared_ptr<Mission> mission = BeginMission(name, "");
  const absl::Status begun = mission->profile().Begin(profile);
  if (!begun.ok()) {
    // What the caller was told is not there must not be there after a restart either.
    const absl::Status removed = journal_->DeleteMission(name);
    LOG_IF(WARNING, !removed.ok()) << "mission " << name << " was not made, but may be there after "
                                   << "the next start: " << removed;
    mission.reset();
    if (leases_ != nullptr) leases_->LetGo(name);
  }
  directory_->EndMaking(name, std::move(mission));
  return begun;
}

absl::Status MapStore::UpdateMission(absl::string_view mission_name, const MissionProfile& values,
                                     const std::vector<ProfileField>& fields,
                                     std::optional<uint64_t> expected_revision) {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->profile().Update(values, fields, expected_revision);
}

absl::Status MapStore::SetRobotSettings(absl::string_view mission_name, const std::string& agent,
                                        const SignedSettings& settings) {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  RETURN_IF_ERROR(mission->profile().SetRobotSettings(agent, settings));
  mission->listeners().CallAllBut(/*except_session=*/0);
  return absl::OkStatus();
}

std::vector<SignedSettings> MapStore::NewerSettings(uint64_t session_id,
                                                    SettingsVersions& told) const {
  const absl::StatusOr<Session> session = FindSession(session_id);
  if (!session.ok()) return {};
  return session->mission->profile().NewerSettings(session->agent, told);
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

void MapStore::TendMissions() {
  for (const KnownMission& known : directory_->List("", std::numeric_limits<size_t>::max())) {
    if (known.mission != nullptr) {
      ProfileKeeper& profile = known.mission->profile();
      if (known.is_used || known.mission->IsWatched()) profile.NoteUse();
      // The journal itself says what is wrong with it; the next time is soon enough.
      profile.KeepUse().IgnoreError();
    }
    if (IsOutdated(known, clock_())) Expire(known.name);
  }
  // Reading what all missions of a fleet fell asleep with is not for every minute.
  if (leases_ != nullptr && tendings_++ % kTendingsToAsleep == 0) ExpireAsleep();
}

void MapStore::ExpireAsleep() {
  std::string after;
  while (true) {
    const absl::StatusOr<std::vector<DirectoryMission>> listed =
        leases_->List(after, kListedAtOnce);
    if (!listed.ok() || listed->empty()) return;
    after = listed->back().name;
    for (const DirectoryMission& mission : *listed) {
      const absl::StatusOr<MissionSummary> summary = DecodeSummary(mission.summary);
      if (!mission.is_asleep || !summary.ok()) continue;
      KnownMission known;
      known.evicted = std::make_shared<const EvictedMission>(EvictedMission{*summary, {}});
      if (!IsOutdated(known, clock_()) || !TakeIn(mission.name).ok()) continue;
      Expire(mission.name);
      directory_->Remove(mission.name, nullptr);
    }
  }
}

void MapStore::Expire(const std::string& name) {
  // What is damaged is for people to look at first.
  if (!journal_->Damage(name).ok()) return;
  MissionProfile profile;
  std::string uid;
  absl::Status deleted;
  {
    absl::MutexLock deleting(&deletion_mutex_);
    // A robot may have come since; from here on none can.
    const std::optional<KnownMission> known = directory_->BeginExpiry(
        name, [this](const KnownMission& now) { return IsOutdated(now, clock_()); });
    if (!known.has_value()) return;
    profile = ProfileOf(*known);
    uid = known->mission != nullptr ? known->mission->uid() : known->evicted->summary.info.uid;
    if (known->mission != nullptr) known->mission->Delete();
    deleted = EndLife(name, known->mission);
  }
  ExpiryListener listener;
  {
    absl::MutexLock lock(&mutex_);
    listener = expiry_listener_;
  }
  const std::string why =
      absl::StrCat("nobody has used it since ",
                   absl::FormatTime("%Y-%m-%dT%H:%M:%SZ", absl::FromUnixNanos(profile.last_used_ns),
                                    absl::UTCTimeZone()),
                   ", its retention is ", profile.retention_s, " s, its uid ", uid);
  LOG_IF(WARNING, !deleted.ok()) << "mission " << name << " is to be deleted, as " << why
                                 << ", and could not be: " << deleted;
  if (!deleted.ok()) return;
  LOG(INFO) << "mission " << name << " deleted: " << why;
  if (listener != nullptr) listener(name, why);
}

}  // namespace corbslam::map_store
