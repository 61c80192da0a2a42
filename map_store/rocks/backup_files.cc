#include "map_store/rocks/backup_files.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "map_store/rocks/backup_note.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// RocksDB's folder of what backups share.
constexpr char kShared[] = "shared_checksum/";

// A file's name without its ending, up to the first underline: its number, in both places. What is
// of the same number and size is taken for the same file; that is for an estimate only.
std::pair<std::string, uint64_t> KeyOf(absl::string_view name, uint64_t size) {
  const absl::string_view file = name.substr(name.rfind('/') + 1);
  return {std::string(file.substr(0, file.find_first_of("_."))), size};
}

rocksdb::BackupEngineOptions MakeBackupOptions(const std::string& folder) {
  rocksdb::BackupEngineOptions made(folder);
  made.share_table_files = true;
  made.sync = true;
  made.max_background_operations = 1;
  return made;
}

}  // namespace

absl::Status ToBackupStatus(absl::string_view place, const rocksdb::Status& status) {
  if (status.ok()) return absl::OkStatus();
  const std::string message = absl::StrCat("backup ", place, ": ", status.ToString());
  if (status.IsNoSpace()) return absl::ResourceExhaustedError(message);
  if (status.IsCorruption()) return absl::DataLossError(message);
  if (status.IsNotFound() || status.IsPathNotFound()) return absl::NotFoundError(message);
  if (status.IsIncomplete()) return absl::AbortedError(message);
  return absl::UnavailableError(message);
}

absl::StatusOr<std::unique_ptr<rocksdb::BackupEngine>> OpenToWrite(const std::string& folder,
                                                                   const BackupOptions& options) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return absl::UnavailableError(absl::StrCat("backup ", folder, ": ", error.message()));
  rocksdb::BackupEngineOptions made = MakeBackupOptions(folder);
  made.backup_rate_limit = options.bytes_per_s;
  // Notice soon that a backup is to end.
  made.callback_trigger_interval_size = 1 << 20;
  rocksdb::BackupEngine* engine = nullptr;
  const rocksdb::IOStatus opened =
      rocksdb::BackupEngine::Open(made, rocksdb::Env::Default(), &engine);
  RETURN_IF_ERROR(ToBackupStatus(folder, opened));
  return std::unique_ptr<rocksdb::BackupEngine>(engine);
}

absl::StatusOr<std::unique_ptr<rocksdb::BackupEngineReadOnly>> OpenToRead(
    const std::string& folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) {
    return absl::NotFoundError(absl::StrCat("there are no backups in ", folder));
  }
  rocksdb::BackupEngineReadOnly* engine = nullptr;
  const rocksdb::IOStatus opened = rocksdb::BackupEngineReadOnly::Open(
      MakeBackupOptions(folder), rocksdb::Env::Default(), &engine);
  RETURN_IF_ERROR(ToBackupStatus(folder, opened));
  return std::unique_ptr<rocksdb::BackupEngineReadOnly>(engine);
}

absl::StatusOr<StoredBackup> Describe(absl::string_view mission, const rocksdb::BackupInfo& info) {
  ASSIGN_OR_RETURN(const BackupNote note, DecodeBackupNote(info.app_metadata));
  return StoredBackup{std::string(mission), info.backup_id, info.size, note.facts};
}

absl::StatusOr<uint64_t> EstimateNewBytes(const rocksdb::BackupEngineReadOnlyBase& engine,
                                          rocksdb::DB& db) {
  std::vector<rocksdb::BackupInfo> backups;
  engine.GetBackupInfo(&backups, /*include_file_details=*/true);
  std::set<std::pair<std::string, uint64_t>> there;
  for (const rocksdb::BackupInfo& backup : backups) {
    for (const rocksdb::BackupFileInfo& file : backup.file_details) {
      const bool is_shared = file.relative_filename.rfind(kShared, 0) == 0;
      if (is_shared) there.insert(KeyOf(file.relative_filename, file.size));
    }
  }
  std::vector<rocksdb::LiveFileStorageInfo> live;
  rocksdb::LiveFilesStorageInfoOptions as_it_is;
  as_it_is.wal_size_for_flush = ~uint64_t{0};
  const rocksdb::Status listed = db.GetLiveFilesStorageInfo(as_it_is, &live);
  RETURN_IF_ERROR(ToBackupStatus(db.GetName(), listed));
  uint64_t bytes = 0;
  for (const rocksdb::LiveFileStorageInfo& file : live) {
    const bool is_shared =
        file.file_type == rocksdb::kTableFile || file.file_type == rocksdb::kBlobFile;
    if (is_shared && there.contains(KeyOf(file.relative_filename, file.size))) continue;
    bytes += file.size;
  }
  return bytes;
}

absl::Status CheckRoomForBackup(const std::string& folder, uint64_t bytes,
                                const BackupOptions& options) {
  uint64_t free = 0;
  if (options.free_bytes != nullptr) {
    ASSIGN_OR_RETURN(free, options.free_bytes(folder));
  } else {
    std::error_code error;
    const auto space = std::filesystem::space(folder, error);
    // Where the system doesn't tell how much room there is, the write will.
    if (error) return absl::OkStatus();
    free = space.available;
  }
  if (free >= bytes + options.min_free_bytes) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("backup ", folder, ": it takes about ", bytes, " bytes, and the disk has ", free,
                   " free, of which ", options.min_free_bytes,
                   " are kept: make room, keep fewer (--backup-keep), or take a larger disk"));
}

}  // namespace corbslam::map_store
