// Does what operators do with the backups that a running map store keeps.
#ifndef CORBSLAM_SERVICES_TOOL_MISSION_BACKUP_ADMIN_H_
#define CORBSLAM_SERVICES_TOOL_MISSION_BACKUP_ADMIN_H_

#include <grpcpp/channel.h>

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"

namespace corbslam::services {

// Speaks to one map store. Thread-safe. Errors are those of the store, with the call that met them.
// Calls that read or write a whole mission have no deadline.
class BackupAdmin {
 public:
  explicit BackupAdmin(const std::shared_ptr<grpc::Channel>& channel);

  absl::StatusOr<v1::StoredBackup> Store(const std::string& mission);
  // Lists those of one mission, or of all (empty name).
  absl::StatusOr<std::vector<v1::StoredBackup>> List(const std::string& mission);
  // `backup` is missions/{mission}/backups/{number}, here and below.
  absl::StatusOr<v1::StoredBackup> Verify(const std::string& backup);
  // Returns the one of that name as it is listed; NOT_FOUND also of one whose list of files is
  // damaged.
  absl::StatusOr<v1::StoredBackup> Find(const std::string& backup);
  // Deletes it, if it is the one that was made then (0: whichever it is), and returns what it was.
  absl::StatusOr<v1::StoredBackup> Delete(const std::string& backup, int64_t created_ns);
  absl::StatusOr<v1::StoredBackup> Archive(const std::string& mission);
  // Makes a mission of it; an empty name is that which it had.
  absl::StatusOr<v1::Mission> Restore(const std::string& backup, const std::string& mission);
  // Returns the mission's newest backup that is not newer than `at`. NOT_FOUND says which there
  // are.
  absl::StatusOr<v1::StoredBackup> FindAt(const std::string& mission, absl::Time at);

 private:
  std::unique_ptr<v1::MapStore::Stub> stub_;
};

// Reads a time as RFC 3339 has it, with its zone. INVALID_ARGUMENT says what is wanted.
absl::StatusOr<absl::Time> ParseBackupTime(const std::string& text);

// The fields are those of corbslam.v1.StoredBackup, and the time for people.
nlohmann::ordered_json ToJson(const v1::StoredBackup& backup);
// Writes a table with a line each.
std::string FormatBackups(const std::vector<v1::StoredBackup>& backups);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_MISSION_BACKUP_ADMIN_H_
