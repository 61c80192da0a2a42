#include "map_store/store/stored_backups.h"

#include <glog/logging.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "map_store/mission/mission_strand.h"
#include "map_store/view/page_tokens.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// The key of a backup in lists: its numbers sort as texts do.
std::string KeyOfBackup(const StoredBackup& backup) {
  return absl::StrFormat("%s/%010d", backup.mission, backup.number);
}

// A backup's records are read in this environment, without a vocabulary: they decide nothing any
// more.
MissionEnvironment ReadingEnvironment(const MapStoreOptions& options, Journal& journal,
                                      const MapStore::Clock& clock) {
  MissionEnvironment environment;
  environment.options = &options;
  environment.journal = &journal;
  environment.clock = clock;
  environment.wake_fusion = [] {};
  return environment;
}

}  // namespace

StoredBackups::StoredBackups(MapStore* store, std::unique_ptr<BackupShelf> shelf, size_t keep,
                             MapStore::Clock clock)
    : store_(*store), shelf_(std::move(shelf)), keep_(keep), clock_(std::move(clock)) {}

absl::StatusOr<BackupFacts> StoredBackups::FactsOf(const std::string& mission) const {
  ASSIGN_OR_RETURN(const MissionInfo info, store_.GetMission(mission));
  if (!info.damage.empty()) {
    return absl::DataLossError(absl::StrCat(
        "no backup of mission ", mission, " can be stored: ", info.damage,
        ". What is in memory still can be had by `corbslam mission backup`, if the damage was "
        "found while the store runs; backups that were stored before can be restored"));
  }
  BackupFacts facts;
  facts.created = clock_();
  facts.mission_uid = info.uid;
  facts.revision = info.revision;
  facts.keyframes = info.keyframes;
  return facts;
}

absl::StatusOr<StoredBackup> StoredBackups::Store(const std::string& mission) {
  ASSIGN_OR_RETURN(const BackupFacts facts, FactsOf(mission));
  ASSIGN_OR_RETURN(const std::shared_ptr<const void> awake, store_.HoldAwake(mission));
  ASSIGN_OR_RETURN(StoredBackup made, shelf_->Store(mission, facts));
  // The new one is there, whatever becomes of the old ones.
  const absl::Status purged = shelf_->Purge(mission, keep_);
  LOG_IF(WARNING, !purged.ok()) << "old backups of mission " << mission << " stay: " << purged;
  return made;
}

bool StoredBackups::SleepsAsStored(const std::string& mission, const StoredBackup& backup) const {
  const absl::StatusOr<MissionInfo> info = store_.GetMission(mission);
  // Fusion may have gone on after the last use, and before the mission fell asleep.
  return info.ok() && info->asleep && info->revision == backup.facts.revision &&
         info->keyframes == backup.facts.keyframes &&
         absl::FromUnixNanos(info->profile.last_used_ns) < backup.facts.created;
}

absl::StatusOr<bool> StoredBackups::StoreIfChanged(const std::string& mission,
                                                   absl::Duration least_age) {
  ASSIGN_OR_RETURN(const MissionInfo info, store_.GetMission(mission));
  ASSIGN_OR_RETURN(const std::vector<StoredBackup> backups, shelf_->List(mission));
  // Those of earlier missions of the name are no backups of this one.
  const auto last = std::find_if(backups.rbegin(), backups.rend(), [&](const StoredBackup& backup) {
    return backup.facts.mission_uid.empty() || backup.facts.mission_uid == info.uid;
  });
  // A damaged one is as good as none, and what it shares with a new one is mended.
  if (last != backups.rend() && last->damage.empty()) {
    const absl::Duration age = clock_() - last->facts.created;
    // A time to come is one of a clock that was wrong.
    if (age >= absl::ZeroDuration() && age < least_age) return false;
    if (SleepsAsStored(mission, *last) || shelf_->IsCurrent(*last)) return false;
  }
  RETURN_IF_ERROR(Store(mission).status());
  return true;
}

absl::StatusOr<Page<StoredBackup>> StoredBackups::List(absl::string_view mission,
                                                       const PageRequest& request) const {
  std::vector<std::string> missions = {std::string(mission)};
  if (mission.empty()) {
    ASSIGN_OR_RETURN(missions, shelf_->ListMissions());
  }
  ASSIGN_OR_RETURN(const PageStart start,
                   ReadPageStart(request, std::numeric_limits<size_t>::max() / 2,
                                 absl::StrCat(mission, "/backups")));
  const std::string first = start.after.substr(0, start.after.rfind('/'));
  Page<StoredBackup> page;
  for (const std::string& name : missions) {
    if (page.items.size() > start.size) break;
    // Names and keys need not sort alike.
    if (!first.empty() && name < first) continue;
    ASSIGN_OR_RETURN(const std::vector<StoredBackup> backups, shelf_->List(name));
    for (const StoredBackup& backup : backups) {
      if (name == first && KeyOfBackup(backup) <= start.after) continue;
      page.items.push_back(backup);
    }
  }
  page.next_page_token = EndPage(start, page.items, &KeyOfBackup);
  return page;
}

absl::StatusOr<StoredBackup> StoredBackups::Verify(const std::string& mission,
                                                   uint32_t number) const {
  ASSIGN_OR_RETURN(StoredBackup backup, shelf_->Find(mission, number));
  RETURN_IF_ERROR(shelf_->Verify(mission, number));
  return backup;
}

absl::StatusOr<StoredBackup> StoredBackups::Remove(const std::string& mission, uint32_t number,
                                                   std::optional<absl::Time> created) {
  absl::StatusOr<StoredBackup> backup = shelf_->Find(mission, number);
  const bool is_unreadable = absl::IsDataLoss(backup.status());
  if (is_unreadable) {
    backup = StoredBackup();
    backup->mission = mission;
    backup->number = number;
    backup->damage = "its list of files can't be read";
  }
  RETURN_IF_ERROR(backup.status());
  if (created.has_value() && !is_unreadable && backup->facts.created != *created) {
    return absl::FailedPreconditionError(absl::StrCat(
        "backup ", number, " of mission ", mission, " is of ",
        absl::FormatTime(absl::RFC3339_full, backup->facts.created, absl::UTCTimeZone()),
        " by now, and another one was meant"));
  }
  RETURN_IF_ERROR(shelf_->Remove(mission, number));
  return backup;
}

absl::Status StoredBackups::CompareAll(const std::function<bool(uint64_t bytes)>& pace) {
  ASSIGN_OR_RETURN(const std::vector<std::string> missions, shelf_->ListMissions());
  for (const std::string& mission : missions) RETURN_IF_ERROR(shelf_->Compare(mission, pace));
  return absl::OkStatus();
}

absl::Status StoredBackups::Restore(const std::string& mission, uint32_t number,
                                    const std::string& name) {
  ASSIGN_OR_RETURN(const StoredBackup backup, shelf_->Find(mission, number));
  RETURN_IF_ERROR(store_.CheckRoomToRestore(name, backup.bytes));
  ASSIGN_OR_RETURN(const std::unique_ptr<Journal> journal, shelf_->Open(mission, number));
  const MapStoreOptions options;
  MissionState state;
  {
    MissionStrand strand(mission, ReadingEnvironment(options, *journal, clock_));
    RETURN_IF_ERROR(strand.Recover());
    StateWriteLock lock(strand);
    state = std::move(strand.mutable_state());
  }
  RETURN_IF_ERROR(store_.RestoreMission(name, std::move(state)));
  store_.TakePictures(name, *journal, mission);
  return absl::OkStatus();
}

absl::Status StoredBackups::CheckReadsBack(const StoredBackup& backup) const {
  ASSIGN_OR_RETURN(const std::unique_ptr<Journal> journal,
                   shelf_->Open(backup.mission, backup.number));
  const MapStoreOptions options;
  const MissionStrand strand(backup.mission, ReadingEnvironment(options, *journal, clock_));
  Journal::Position until = std::numeric_limits<Journal::Position>::max();
  ASSIGN_OR_RETURN(const MissionState state, strand.ReplayUntil(until, [] { return true; }));
  uint64_t keyframes = 0;
  for (const auto& [id, local_map] : state.local_maps)
    keyframes += local_map.map.keyframes().size();
  if (keyframes == backup.facts.keyframes) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat("the backup of mission ", backup.mission, " has ",
                                          keyframes, " keyframes, and the mission had ",
                                          backup.facts.keyframes));
}

absl::Status StoredBackups::DeleteArchived(const StoredBackup& backup) {
  RETURN_IF_ERROR(shelf_->Verify(backup.mission, backup.number));
  RETURN_IF_ERROR(CheckReadsBack(backup));
  return store_.DeleteUnusedMission(backup.mission, [&]() -> absl::Status {
    if (shelf_->IsCurrent(backup)) return absl::OkStatus();
    return absl::FailedPreconditionError(
        absl::StrCat("mission ", backup.mission,
                     " has changed while it was being archived: it stays; try again once it is "
                     "at rest"));
  });
}

absl::StatusOr<StoredBackup> StoredBackups::Archive(const std::string& mission) {
  ASSIGN_OR_RETURN(BackupFacts facts, FactsOf(mission));
  ASSIGN_OR_RETURN(const std::shared_ptr<const void> awake, store_.HoldAwake(mission));
  RETURN_IF_ERROR(store_.CheckNobodyConnected(mission));
  facts.archived = true;
  ASSIGN_OR_RETURN(StoredBackup made, shelf_->Store(mission, facts));
  const absl::Status deleted = DeleteArchived(made);
  if (deleted.ok()) return made;
  // It would say that the mission went.
  const absl::Status removed = shelf_->Remove(mission, made.number);
  LOG_IF(WARNING, !removed.ok()) << "mission " << mission << " was not archived, and the backup "
                                 << "that says so stays: " << removed;
  return deleted;
}

}  // namespace corbslam::map_store
