#include <glog/logging.h>

#include "services/convert/resource_names.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/observe/logging/log_fields.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

grpc::ServerUnaryReactor* MapStoreService::SleepMission(grpc::CallbackServerContext* context,
                                                        const v1::SleepMissionRequest* request,
                                                        v1::Mission* response) {
  return AnswerLong(
      long_pool_, context, request->name(), [this, request, response]() -> absl::Status {
        ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request->name()));
        RETURN_IF_ERROR(store_.SleepMission(mission));
        LOG(INFO) << LogFields{.mission = mission} << "mission put to sleep";
        ASSIGN_OR_RETURN(const map_store::MissionInfo info, store_.GetMission(mission));
        ToProto(info, response);
        return absl::OkStatus();
      });
}

}  // namespace corbslam::services
