// Remembers beside a mission's backups when they were last compared with their checksums, and what
// was damaged.
#ifndef CORBSLAM_MAP_STORE_ROCKS_BACKUP_HEALTH_H_
#define CORBSLAM_MAP_STORE_ROCKS_BACKUP_HEALTH_H_

#include <cstdint>
#include <map>
#include <string>

#include "absl/status/status.h"
#include "absl/time/time.h"

namespace corbslam::map_store {

struct BackupHealth {
  absl::Time verified = absl::InfinitePast();  // When all of it was right; InfinitePast: never.
  std::string damage;                          // Empty: none that is known of.
  friend bool operator==(const BackupHealth&, const BackupHealth&) = default;
};
using HealthByNumber = std::map<uint32_t, BackupHealth>;

// Reads what is remembered in the folder of one mission's backups. A line that can't be read counts
// as if there were none: those backups are compared again.
HealthByNumber ReadBackupHealth(const std::string& folder);
absl::Status WriteBackupHealth(const std::string& folder, const HealthByNumber& health);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_BACKUP_HEALTH_H_
