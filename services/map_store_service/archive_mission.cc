#include <glog/logging.h>

#include "services/convert/resource_names.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/stored_backup_message.h"
#include "services/observe/logging/log_fields.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

grpc::ServerUnaryReactor* MapStoreService::ArchiveMission(grpc::CallbackServerContext* context,
                                                          const v1::ArchiveMissionRequest* request,
                                                          v1::StoredBackup* response) {
  return AnswerLong(
      backup_pool_, context, request->name(), [this, request, response]() -> absl::Status {
        ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request->name()));
        RETURN_IF_ERROR(CheckKeepsBackups(options_.backups));
        ASSIGN_OR_RETURN(const map_store::StoredBackup made, options_.backups->Archive(mission));
        LOG(INFO) << LogFields{.mission = mission} << "mission archived as backup " << made.number;
        ToProto(made, response);
        return absl::OkStatus();
      });
}

}  // namespace corbslam::services
