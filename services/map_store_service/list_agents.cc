#include "services/convert/resource_names.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/paging.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::PageRequest;

grpc::ServerUnaryReactor* MapStoreService::ListAgents(grpc::CallbackServerContext* context,
                                                      const v1::ListAgentsRequest* request,
                                                      v1::ListAgentsResponse* response) {
  return AnswerOn(pool_, context, [this, request, response]() -> absl::Status {
    ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request->parent()));
    ASSIGN_OR_RETURN(const PageRequest page, ReadPage(*request));
    ASSIGN_OR_RETURN(const auto found, store_.ListAgents(mission, page));
    for (const auto& item : found.items) ToProto(mission, item, response->add_agents());
    response->set_next_page_token(found.next_page_token);
    return absl::OkStatus();
  });
}

}  // namespace corbslam::services
