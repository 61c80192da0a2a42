#include "map_store/rocks/backup_folder.h"

#include <glog/logging.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/archive/formats.h"
#include "map_store/ingest/batch_validation.h"
#include "map_store/rocks/backup_owner.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/rocks_journal.h"
#include "slam/util/program_version.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

absl::Status CheckApart(const std::string& backups, const std::string& data) {
  if (!IsWithin(backups, data) && !IsWithin(data, backups)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("--backup-dir is ", backups, ", and --data-dir is ", data,
                   ": neither may be in the other; what loses the one would lose both. Take "
                   "another folder, best on another disk"));
}

// Tells backups of missions that had one name apart: those that say no uid by their database.
class MissionNamer {
 public:
  explicit MissionNamer(const std::vector<rocksdb::BackupInfo>& backups) {
    for (const rocksdb::BackupInfo& backup : backups) {
      const absl::StatusOr<BackupNote> note = DecodeBackupNote(backup.app_metadata);
      if (!note.ok() || note->facts.mission_uid.empty()) continue;
      uids_[note->mark.identity] = note->facts.mission_uid;
    }
  }
  std::string NameOf(const BackupNote& note) const {
    if (!note.facts.mission_uid.empty()) return note.facts.mission_uid;
    const auto it = uids_.find(note.mark.identity);
    return it == uids_.end() ? note.mark.identity : it->second;
  }

 private:
  std::map<std::string, std::string> uids_;  // By the database's identity.
};

// A name that leads out of the folder of backups.
absl::Status CheckBackupName(absl::string_view mission) {
  RETURN_IF_ERROR(map_store::ValidateName("mission", std::string(mission)));
  if (mission.front() != '.') return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("mission ", mission, " begins with a dot: it can't have backups"));
}

}  // namespace

absl::StatusOr<std::unique_ptr<BackupFolder>> BackupFolder::Open(const RocksJournal* journal,
                                                                 const BackupOptions& options) {
  RETURN_IF_ERROR(CheckApart(options.directory, journal->options().directory));
  std::error_code error;
  std::filesystem::create_directories(options.directory, error);
  if (error) {
    return absl::UnavailableError(
        absl::StrCat("--backup-dir ", options.directory, ": ", error.message()));
  }
  // RocksDB opens a backup's database by an absolute path only.
  BackupOptions absolute = options;
  absolute.directory = std::filesystem::absolute(options.directory, error).string();
  const std::string& data = journal->options().directory;
  ASSIGN_OR_RETURN(const std::string store_id, EnsureStoreId(data));
  RETURN_IF_ERROR(ClaimBackupFolder(absolute.directory, store_id, data, absolute.take_over_from));
  std::unique_ptr<BackupFolder> folder(new BackupFolder(journal, std::move(absolute), store_id));
  folder->LoadHealth();
  return folder;
}

absl::Status BackupFolder::CheckOwner() const {
  // Where the file has gone, this store is the owner still.
  return ClaimBackupFolder(options_.directory, store_id_, journal_->options().directory, "");
}

std::string BackupFolder::FolderOf(absl::string_view mission) const {
  return absl::StrCat(options_.directory, "/", mission);
}

std::string BackupFolder::PlaceOf(absl::string_view mission, uint32_t number) const {
  return absl::StrCat(FolderOf(mission), ", number ", number);
}

absl::StatusOr<StoredBackup> BackupFolder::Store(absl::string_view mission,
                                                 const BackupFacts& facts) {
  RETURN_IF_ERROR(CheckBackupName(mission));
  // Else an empty folder would be left of a mission that there is not.
  RETURN_IF_ERROR(journal_->Mark(mission).status());
  absl::MutexLock writing(&writing_);
  if (interrupted_) return absl::AbortedError("the store is about to end");
  RETURN_IF_ERROR(CheckOwner());
  const std::string folder = FolderOf(mission);
  ASSIGN_OR_RETURN(const std::unique_ptr<rocksdb::BackupEngine> engine,
                   OpenToWrite(folder, options_));
  const absl::StatusOr<uint32_t> number = Write(*engine, mission, facts);
  if (!number.ok()) {
    const rocksdb::IOStatus collected = engine->GarbageCollect();
    LOG_IF(WARNING, !collected.ok()) << folder << ": what a backup that failed has left is still "
                                     << "there: " << collected.ToString();
    return number.status();
  }
  NoteHealth(mission, *number, absl::OkStatus());
  ASSIGN_OR_RETURN(const rocksdb::BackupInfo info, ReadInfo(*engine, mission, *number));
  ASSIGN_OR_RETURN(StoredBackup made, map_store::Describe(mission, info));
  AddHealth(made);
  return made;
}

absl::StatusOr<uint32_t> BackupFolder::Write(rocksdb::BackupEngine& engine,
                                             absl::string_view mission,
                                             const BackupFacts& facts) const {
  const std::string folder = FolderOf(mission);
  uint32_t number = 0;
  absl::Status room;
  rocksdb::IOStatus made;
  absl::Status compared;
  RETURN_IF_ERROR(journal_->Lend(
      mission, [&](rocksdb::DB& db, const std::function<bool()>& goes_on) -> rocksdb::Status {
        BackupNote note{facts, {}, kJournalFormat, CorbslamVersion()};
        // What is written from here on makes the next backup differ.
        note.mark.sequence = db.GetLatestSequenceNumber();
        const rocksdb::Status known = db.GetDbIdentity(note.mark.identity);
        if (!known.ok()) return known;
        const absl::StatusOr<uint64_t> bytes = EstimateNewBytes(engine, db);
        room = bytes.ok() ? CheckRoomForBackup(folder, *bytes, options_) : bytes.status();
        if (!room.ok()) return rocksdb::Status::OK();
        rocksdb::CreateBackupOptions how;
        // Tables are shared with other backups, and a log is not.
        how.flush_before_backup = true;
        how.progress_callback = [&] {
          if (interrupted_ || !goes_on()) engine.StopBackup();
        };
        // Its errors may be the backups' disk's, which say nothing of the mission.
        made = engine.CreateNewBackupWithMetadata(how, &db, Encode(note), &number);
        if (made.ok()) compared = CompareNew(db, mission, number, goes_on);
        return rocksdb::Status::OK();
      }));
  RETURN_IF_ERROR(room);
  RETURN_IF_ERROR(ToBackupStatus(folder, made));
  if (compared.ok()) return number;
  // One that is not sound is none.
  const rocksdb::IOStatus removed = engine.DeleteBackup(number);
  LOG_IF(WARNING, !removed.ok()) << PlaceOf(mission, number)
                                 << " is damaged and stays: " << removed.ToString();
  if (absl::IsCancelled(compared)) return absl::AbortedError(compared.message());
  return compared;
}

bool BackupFolder::IsStillThere(absl::string_view mission, const BackupNote& note) const {
  const absl::StatusOr<DatabaseMark> mark = journal_->Mark(mission);
  return mark.ok() && mark->identity == note.mark.identity;
}

bool BackupFolder::IsCurrent(const StoredBackup& backup) const {
  const auto engine = OpenToRead(FolderOf(backup.mission));
  if (!engine.ok()) return false;
  const auto info = ReadInfo(**engine, backup.mission, backup.number);
  if (!info.ok()) return false;
  const absl::StatusOr<BackupNote> note = DecodeBackupNote(info->app_metadata);
  const absl::StatusOr<DatabaseMark> mark = journal_->Mark(backup.mission);
  return note.ok() && mark.ok() && *mark == note->mark;
}

absl::Status BackupFolder::Purge(absl::string_view mission, size_t keep) {
  absl::MutexLock writing(&writing_);
  RETURN_IF_ERROR(CheckOwner());
  ASSIGN_OR_RETURN(const std::unique_ptr<rocksdb::BackupEngine> engine,
                   OpenToWrite(FolderOf(mission), options_));
  std::vector<rocksdb::BackupInfo> backups;
  engine->GetBackupInfo(&backups);
  const MissionNamer namer(backups);
  std::map<std::string, size_t> kept;
  std::sort(backups.begin(), backups.end(),
            [](const auto& a, const auto& b) { return a.backup_id > b.backup_id; });
  for (const rocksdb::BackupInfo& backup : backups) {
    const absl::StatusOr<BackupNote> note = DecodeBackupNote(backup.app_metadata);
    // What this program can't read, a newer one may.
    if (!note.ok() || note->facts.archived) continue;
    size_t& of_mission = kept[namer.NameOf(*note)];
    if (of_mission < std::max<size_t>(keep, 1)) {
      of_mission += IsDamaged(mission, backup.backup_id) ? 0 : 1;
      continue;
    }
    if (IsInUse(mission, backup.backup_id)) continue;
    const rocksdb::IOStatus removed = engine->DeleteBackup(backup.backup_id);
    RETURN_IF_ERROR(ToBackupStatus(PlaceOf(mission, backup.backup_id), removed));
    ForgetHealth(mission, backup.backup_id);
  }
  std::vector<rocksdb::BackupID> damaged;
  engine->GetCorruptedBackups(&damaged);
  for (const rocksdb::BackupID number : damaged) {
    LOG(WARNING) << PlaceOf(mission, number)
                 << " is damaged: " << ReadInfo(*engine, mission, number).status();
  }
  return absl::OkStatus();
}

absl::Status BackupFolder::Remove(absl::string_view mission, uint32_t number) {
  absl::MutexLock writing(&writing_);
  RETURN_IF_ERROR(CheckOwner());
  if (IsInUse(mission, number)) {
    return absl::FailedPreconditionError(
        absl::StrCat("backup ", PlaceOf(mission, number), " is being read: try again later"));
  }
  ASSIGN_OR_RETURN(const std::unique_ptr<rocksdb::BackupEngine> engine,
                   OpenToWrite(FolderOf(mission), options_));
  RETURN_IF_ERROR(ToBackupStatus(PlaceOf(mission, number), engine->DeleteBackup(number)));
  ForgetHealth(mission, number);
  return absl::OkStatus();
}

}  // namespace corbslam::map_store
