#include <glog/logging.h>

#include "services/convert/resource_names.h"
#include "services/map_store_service/map_store_service.h"
#include "services/observe/logging/log_fields.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

grpc::ServerUnaryReactor* MapStoreService::RederiveGlobalLayer(
    grpc::CallbackServerContext* context, const v1::RederiveGlobalLayerRequest* request,
    v1::RederiveGlobalLayerResponse*) {
  return AnswerLong(long_pool_, context, request->name(), [this, request]() -> absl::Status {
    ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request->name()));
    RETURN_IF_ERROR(store_.RederiveGlobalLayer(mission));
    LOG(INFO) << LogFields{.mission = mission} << "fusion begins afresh";
    return absl::OkStatus();
  });
}

}  // namespace corbslam::services
