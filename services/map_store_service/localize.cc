#include "services/convert/resource_names.h"
#include "services/map_store_service/localize_convert.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

absl::Status MapStoreService::AnswerLocalize(const v1::LocalizeRequest& request,
                                             const std::function<bool()>& goes_on,
                                             v1::LocalizeResponse* response) {
  ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request.mission()));
  ASSIGN_OR_RETURN(const map_store::LocalizeQuery query, LocalizeQueryFromProto(request));
  ASSIGN_OR_RETURN(const map_store::LocalizeAnswer answer,
                   store_.Localize(mission, query, goes_on));
  ToProto(mission, answer, response);
  response->set_id(request.id());
  return absl::OkStatus();
}

grpc::ServerUnaryReactor* MapStoreService::Localize(grpc::CallbackServerContext* context,
                                                    const v1::LocalizeRequest* request,
                                                    v1::LocalizeResponse* response) {
  return AnswerOn(locating_pool_, context, [this, context, request, response] {
    return AnswerLocalize(
        *request, [context] { return !context->IsCancelled(); }, response);
  });
}

}  // namespace corbslam::services
