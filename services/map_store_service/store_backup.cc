#include <glog/logging.h>

#include "services/convert/resource_names.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/stored_backup_message.h"
#include "services/observe/logging/log_fields.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

grpc::ServerUnaryReactor* MapStoreService::StoreBackup(grpc::CallbackServerContext* context,
                                                       const v1::StoreBackupRequest* request,
                                                       v1::StoredBackup* response) {
  return AnswerLong(
      backup_pool_, context, request->name(), [this, request, response]() -> absl::Status {
        ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request->name()));
        RETURN_IF_ERROR(CheckKeepsBackups(options_.backups));
        ASSIGN_OR_RETURN(const map_store::StoredBackup made, options_.backups->Store(mission));
        LOG(INFO) << LogFields{.mission = mission} << "backup " << made.number << " stored";
        ToProto(made, response);
        return absl::OkStatus();
      });
}

}  // namespace corbslam::services
