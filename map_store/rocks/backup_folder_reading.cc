// Implements the part of BackupFolder that changes nothing.
#include <algorithm>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/rocks/backup_folder.h"
#include "map_store/rocks/backup_reader.h"
#include "map_store/rocks/rocks_database.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Holds what a backup's database is read through, and the backup itself.
struct OpenBackup {
  std::shared_ptr<const void> hold;
  rocksdb::BackupInfo info;
};

// Reads all that is in the backup's database: its files may be as they were copied, and have been
// damaged before.
absl::Status ReadAll(const rocksdb::BackupInfo& info, const std::string& place) {
  RocksDatabase database(info.name_for_open, info.env_for_open.get(), MakeBlockCache());
  rocksdb::Status read = database.Open(RocksDatabase::Mode::kOnlyRead);
  if (read.ok()) read = database.VerifyChecksums();
  if (!read.ok()) return absl::DataLossError(absl::StrCat("backup ", place, ": ", read.ToString()));
  const absl::Status scanned =
      database.Scan(std::string(1, '\0'), std::string(1, '\xff'),
                    [](std::string_view, std::string_view) { return absl::OkStatus(); });
  if (scanned.ok()) return scanned;
  return absl::DataLossError(absl::StrCat("backup ", place, ": ", scanned.message()));
}

}  // namespace

std::shared_ptr<const void> BackupFolder::Hold(absl::string_view mission, uint32_t number) const {
  const BackupInUse backup(std::string(mission), number);
  absl::MutexLock lock(&in_use_mutex_);
  in_use_.insert(backup);
  return {this, [backup](const BackupFolder* folder) {
            absl::MutexLock lock(&folder->in_use_mutex_);
            folder->in_use_.erase(folder->in_use_.find(backup));
          }};
}

bool BackupFolder::IsInUse(absl::string_view mission, uint32_t number) const {
  absl::MutexLock lock(&in_use_mutex_);
  return in_use_.contains({std::string(mission), number});
}

absl::StatusOr<rocksdb::BackupInfo> BackupFolder::ReadInfo(
    const rocksdb::BackupEngineReadOnlyBase& engine, absl::string_view mission,
    uint32_t number) const {
  rocksdb::BackupInfo info;
  const rocksdb::Status found = engine.GetBackupInfo(number, &info, /*include_file_details=*/true);
  if (found.IsNotFound()) {
    return absl::NotFoundError(absl::StrCat("there is no backup ", PlaceOf(mission, number)));
  }
  RETURN_IF_ERROR(ToBackupStatus(PlaceOf(mission, number), found));
  return info;
}

absl::StatusOr<std::vector<std::string>> BackupFolder::ListMissions() const {
  std::vector<std::string> missions;
  std::error_code error;
  std::filesystem::directory_iterator it(options_.directory, error);
  for (const std::filesystem::directory_iterator end; !error && it != end; it.increment(error)) {
    std::error_code gone;
    const std::string name = it->path().filename().string();
    // What else lies there is not this program's.
    const bool has_backups = std::filesystem::is_directory(it->path() / "meta", gone);
    if (has_backups && name.front() != '.') missions.push_back(name);
  }
  if (error) {
    return absl::UnavailableError(absl::StrCat(options_.directory, ": ", error.message()));
  }
  std::sort(missions.begin(), missions.end());
  return missions;
}

absl::StatusOr<std::vector<StoredBackup>> BackupFolder::List(absl::string_view mission) const {
  std::vector<StoredBackup> backups;
  const auto engine = OpenToRead(FolderOf(mission));
  if (absl::IsNotFound(engine.status())) return backups;
  RETURN_IF_ERROR(engine.status());
  std::vector<rocksdb::BackupInfo> infos;
  (*engine)->GetBackupInfo(&infos);
  for (const rocksdb::BackupInfo& info : infos) {
    const absl::StatusOr<BackupNote> note = DecodeBackupNote(info.app_metadata);
    // Somebody else's.
    if (!note.ok()) continue;
    StoredBackup backup{std::string(mission), info.backup_id, info.size, note->facts};
    // The process may have ended between the backup and the deletion.
    if (backup.facts.archived && IsStillThere(mission, *note)) backup.facts.archived = false;
    AddHealth(backup);
    backups.push_back(std::move(backup));
  }
  std::ranges::sort(backups, {}, &StoredBackup::number);
  return backups;
}

absl::StatusOr<StoredBackup> BackupFolder::Find(absl::string_view mission, uint32_t number) const {
  ASSIGN_OR_RETURN(const std::unique_ptr<rocksdb::BackupEngineReadOnly> engine,
                   OpenToRead(FolderOf(mission)));
  ASSIGN_OR_RETURN(const rocksdb::BackupInfo info, ReadInfo(*engine, mission, number));
  ASSIGN_OR_RETURN(StoredBackup found, map_store::Describe(mission, info));
  AddHealth(found);
  return found;
}

absl::Status BackupFolder::Verify(absl::string_view mission, uint32_t number) const {
  const std::shared_ptr<const void> hold = Hold(mission, number);
  ASSIGN_OR_RETURN(const std::unique_ptr<rocksdb::BackupEngineReadOnly> engine,
                   OpenToRead(FolderOf(mission)));
  ASSIGN_OR_RETURN(const rocksdb::BackupInfo info, ReadInfo(*engine, mission, number));
  const rocksdb::IOStatus compared = engine->VerifyBackup(number, /*verify_with_checksum=*/true);
  const std::string place = PlaceOf(mission, number);
  absl::Status verified = ToBackupStatus(place, compared);
  if (compared.IsNotFound() || compared.IsCorruption() || compared.IsPathNotFound()) {
    verified = absl::DataLossError(absl::StrCat("backup ", place, ": ", compared.ToString()));
  }
  if (verified.ok()) verified = ReadAll(info, place);
  if (verified.ok() || absl::IsDataLoss(verified)) NoteHealth(mission, number, verified);
  return verified;
}

absl::StatusOr<std::unique_ptr<Journal>> BackupFolder::Open(absl::string_view mission,
                                                            uint32_t number) const {
  auto open = std::make_shared<OpenBackup>();
  open->hold = Hold(mission, number);
  ASSIGN_OR_RETURN(const std::unique_ptr<rocksdb::BackupEngineReadOnly> engine,
                   OpenToRead(FolderOf(mission)));
  ASSIGN_OR_RETURN(open->info, ReadInfo(*engine, mission, number));
  rocksdb::Env* env = open->info.env_for_open.get();
  absl::StatusOr<std::unique_ptr<Journal>> journal =
      BackupReader::Open(std::string(mission), open->info.name_for_open, env, open);
  if (journal.ok()) return journal;
  return absl::Status(journal.status().code(), absl::StrCat("backup ", PlaceOf(mission, number),
                                                            ": ", journal.status().message()));
}

}  // namespace corbslam::map_store
