#include "services/convert/resource_names.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/stored_backup_message.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

grpc::ServerUnaryReactor* MapStoreService::VerifyStoredBackup(
    grpc::CallbackServerContext* context, const v1::VerifyStoredBackupRequest* request,
    v1::StoredBackup* response) {
  return AnswerLong(backup_pool_, context, request->backup(),
                    [this, request, response]() -> absl::Status {
                      ASSIGN_OR_RETURN(const BackupPath path, ParseBackupName(request->backup()));
                      RETURN_IF_ERROR(CheckKeepsBackups(options_.backups));
                      ASSIGN_OR_RETURN(const map_store::StoredBackup verified,
                                       options_.backups->Verify(path.mission, path.number));
                      ToProto(verified, response);
                      return absl::OkStatus();
                    });
}

}  // namespace corbslam::services
