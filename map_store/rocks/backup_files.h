// What a folder of one mission's backups holds, and how it is opened.
#ifndef CORBSLAM_MAP_STORE_ROCKS_BACKUP_FILES_H_
#define CORBSLAM_MAP_STORE_ROCKS_BACKUP_FILES_H_

#include <rocksdb/db.h>
#include <rocksdb/utilities/backup_engine.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "map_store/records/backup_shelf.h"

namespace corbslam::map_store {

struct BackupOptions {
  std::string directory;
  // The id of the store whose folder it was, if this one takes it over (backup_owner.h).
  std::string take_over_from = "";
  // Bytes a second that a backup writes at most; 0: as fast as it goes.
  uint64_t bytes_per_s = uint64_t{32} << 20;
  // Bytes of the folder's disk that a backup leaves free.
  uint64_t min_free_bytes = uint64_t{64} << 20;
  // Returns how many bytes a folder's disk has free; null: as the system says. For tests.
  std::function<absl::StatusOr<uint64_t>(const std::string& folder)> free_bytes;
};

// Returns the status as the callers of BackupShelf expect it.
absl::Status ToBackupStatus(absl::string_view place, const rocksdb::Status& status);

// Opens a mission's folder of backups, which need not be there yet, to write into it. One at a time
// may do so.
absl::StatusOr<std::unique_ptr<rocksdb::BackupEngine>> OpenToWrite(const std::string& folder,
                                                                   const BackupOptions& options);
// Opens one that is there, to read; it knows of those backups that are there now.
absl::StatusOr<std::unique_ptr<rocksdb::BackupEngineReadOnly>> OpenToRead(
    const std::string& folder);

// Returns what is to be shown of the backup; DATA_LOSS if its note can't be read.
absl::StatusOr<StoredBackup> Describe(absl::string_view mission, const rocksdb::BackupInfo& info);

// Returns how many bytes of the database's files no backup there has yet, about.
absl::StatusOr<uint64_t> EstimateNewBytes(const rocksdb::BackupEngineReadOnlyBase& engine,
                                          rocksdb::DB& db);
// Returns RESOURCE_EXHAUSTED, with the numbers, if that is more than the disk has to spare.
absl::Status CheckRoomForBackup(const std::string& folder, uint64_t bytes,
                                const BackupOptions& options);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_BACKUP_FILES_H_
