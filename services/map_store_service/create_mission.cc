#include <glog/logging.h>

#include "services/convert/resource_names.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/profile_convert.h"
#include "services/observe/logging/log_fields.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::MissionInfo;

grpc::ServerUnaryReactor* MapStoreService::CreateMission(grpc::CallbackServerContext* context,
                                                         const v1::CreateMissionRequest* request,
                                                         v1::Mission* response) {
  return AnswerOn(pool_, context, [this, request, response]() -> absl::Status {
    ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request->mission().name()));
    RETURN_IF_ERROR(CheckAskedLimits(request->mission(), {map_store::ProfileField::kLimits,
                                                          map_store::ProfileField::kAgentLimits,
                                                          map_store::ProfileField::kRetention}));
    RETURN_IF_ERROR(store_.CreateMission(mission, ProfileFromProto(request->mission())));
    ASSIGN_OR_RETURN(const MissionInfo info, store_.GetMission(mission));
    LOG(INFO) << LogFields{.mission = mission} << "mission created, uid " << info.uid;
    ToProto(info, response);
    return absl::OkStatus();
  });
}

}  // namespace corbslam::services
