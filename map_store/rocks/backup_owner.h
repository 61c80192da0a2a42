// Says in a folder of backups which store writes into it, so that no second one does.
#ifndef CORBSLAM_MAP_STORE_ROCKS_BACKUP_OWNER_H_
#define CORBSLAM_MAP_STORE_ROCKS_BACKUP_OWNER_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace corbslam::map_store {

inline constexpr char kStoreIdFile[] = "STORE";  // In a journal's folder.
inline constexpr char kOwnerFile[] = "OWNER";    // In a folder of backups.

// Returns what tells the store of this journal's folder from all others; it is drawn the first
// time. Errors name the file.
absl::StatusOr<std::string> EnsureStoreId(const std::string& journal_folder);

// Makes the store the owner of the folder of backups, if it has none, or the one with the id
// `take_over_from`. FAILED_PRECONDITION if another store's; the message says whose it is and what
// to do.
absl::Status ClaimBackupFolder(const std::string& backups, const std::string& store_id,
                               const std::string& journal_folder,
                               const std::string& take_over_from);
// Returns FAILED_PRECONDITION, likewise, if another store has taken the folder over.
absl::Status CheckOwnsBackupFolder(const std::string& backups, const std::string& store_id);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_BACKUP_OWNER_H_
