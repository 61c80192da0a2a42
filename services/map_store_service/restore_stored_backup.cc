#include <glog/logging.h>

#include "services/convert/resource_names.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/stored_backup_message.h"
#include "services/observe/logging/log_fields.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

grpc::ServerUnaryReactor* MapStoreService::RestoreStoredBackup(
    grpc::CallbackServerContext* context, const v1::RestoreStoredBackupRequest* request,
    v1::Mission* response) {
  return AnswerLong(
      backup_pool_, context, request->backup(), [this, request, response]() -> absl::Status {
        ASSIGN_OR_RETURN(const BackupPath path, ParseBackupName(request->backup()));
        std::string name = path.mission;
        if (!request->name().empty()) {
          ASSIGN_OR_RETURN(name, ParseMissionName(request->name()));
        }
        RETURN_IF_ERROR(CheckKeepsBackups(options_.backups));
        RETURN_IF_ERROR(options_.backups->Restore(path.mission, path.number, name));
        LOG(INFO) << LogFields{.mission = name} << "mission restored from " << request->backup();
        ASSIGN_OR_RETURN(const map_store::MissionInfo info, store_.GetMission(name));
        ToProto(info, response);
        return absl::OkStatus();
      });
}

}  // namespace corbslam::services
