#include <glog/logging.h>

#include "services/convert/resource_names.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/paging.h"
#include "services/observe/logging/log_fields.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::MissionInfo;

grpc::ServerUnaryReactor* MapStoreService::DeleteMission(grpc::CallbackServerContext* context,
                                                         const v1::DeleteMissionRequest* request,
                                                         v1::DeleteMissionResponse* response) {
  return AnswerLong(
      long_pool_, context, request->name(), [this, request, response]() -> absl::Status {
        ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request->name()));
        ASSIGN_OR_RETURN(const MissionInfo info, store_.GetMission(mission));
        RETURN_IF_ERROR(store_.DeleteMission(mission, request->uid()));
        LOG(INFO) << LogFields{.mission = mission} << "mission deleted, uid " << info.uid;
        response->set_local_maps(static_cast<uint32_t>(info.local_maps));
        return absl::OkStatus();
      });
}

}  // namespace corbslam::services
