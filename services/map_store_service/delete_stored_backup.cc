#include <glog/logging.h>

#include <optional>

#include "absl/time/time.h"
#include "services/convert/resource_names.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/stored_backup_message.h"
#include "services/observe/logging/log_fields.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

grpc::ServerUnaryReactor* MapStoreService::DeleteStoredBackup(
    grpc::CallbackServerContext* context, const v1::DeleteStoredBackupRequest* request,
    v1::StoredBackup* response) {
  return AnswerLong(
      backup_pool_, context, request->backup(), [this, request, response]() -> absl::Status {
        ASSIGN_OR_RETURN(const BackupPath path, ParseBackupName(request->backup()));
        RETURN_IF_ERROR(CheckKeepsBackups(options_.backups));
        std::optional<absl::Time> created;
        if (request->created_ns() != 0) {
          created = absl::FromUnixNanos(request->created_ns());
        }
        ASSIGN_OR_RETURN(const map_store::StoredBackup removed,
                         options_.backups->Remove(path.mission, path.number, created));
        LOG(INFO) << LogFields{.mission = path.mission} << "backup " << path.number << " deleted";
        ToProto(removed, response);
        return absl::OkStatus();
      });
}

}  // namespace corbslam::services
