// Reads what RocksDB's backup engine wrote down of the files of backups, to compare them with it.
#ifndef CORBSLAM_MAP_STORE_ROCKS_BACKUP_SUMS_H_
#define CORBSLAM_MAP_STORE_ROCKS_BACKUP_SUMS_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace corbslam::map_store {

struct SummedFile {
  std::string name;  // Below the folder of the mission's backups.
  uint32_t checksum = 0;
  // Other backups have it, too, or may.
  bool is_shared() const;
  friend auto operator<=>(const SummedFile&, const SummedFile&) = default;
};

// Returns the files of the backup of this number. NOT_FOUND: there is no such backup; DATA_LOSS:
// its list can't be read.
absl::StatusOr<std::vector<SummedFile>> ReadBackupSums(const std::string& folder, uint32_t number);

// Is told of bytes that are about to be read, and may wait; false: read no more.
using BackupPace = std::function<bool(uint64_t bytes)>;

// Reads the file and compares it with its checksum. DATA_LOSS names it, and what is wrong;
// CANCELLED: `pace` said no.
absl::Status CompareWithSum(const std::string& folder, const SummedFile& file,
                            const BackupPace& pace);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_BACKUP_SUMS_H_
