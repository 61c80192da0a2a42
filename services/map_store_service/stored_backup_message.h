// Converts stored backups to the messages of the contract, and says what a store without any says.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_STORED_BACKUP_MESSAGE_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_STORED_BACKUP_MESSAGE_H_

#include "absl/status/status.h"
#include "corbslam/v1/resources.pb.h"
#include "map_store/store/stored_backups.h"

namespace corbslam::services {

void ToProto(const map_store::StoredBackup& backup, v1::StoredBackup* proto);

// Returns FAILED_PRECONDITION if there are none.
absl::Status CheckKeepsBackups(const map_store::StoredBackups* backups);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_STORED_BACKUP_MESSAGE_H_
