#include "services/convert/resource_names.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

grpc::ServerUnaryReactor* MapStoreService::AskForExactPlaces(
    grpc::CallbackServerContext* context, const v1::AskForExactPlacesRequest* request,
    v1::AskForExactPlacesResponse*) {
  return AnswerOn(pool_, context, [this, request]() -> absl::Status {
    ASSIGN_OR_RETURN(const AgentPath path, ParseAgentName(request->name(), /*may_be_all=*/false));
    return store_.AskForExactPlaces(path.mission, path.agent);
  });
}

}  // namespace corbslam::services
