#include "services/convert/resource_names.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/paging.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::PageRequest;

grpc::ServerUnaryReactor* MapStoreService::ListKeyframes(grpc::CallbackServerContext* context,
                                                         const v1::ListKeyframesRequest* request,
                                                         v1::ListKeyframesResponse* response) {
  return AnswerOn(pool_, context, [this, request, response]() -> absl::Status {
    ASSIGN_OR_RETURN(const LocalMapPath path,
                     ParseLocalMapName(request->parent(), /*may_be_all=*/true));
    ASSIGN_OR_RETURN(const PageRequest page, ReadPage(*request));
    ASSIGN_OR_RETURN(const auto found, store_.ListKeyframes(path.mission, path.local_map, page));
    for (const auto& item : found.items) ToProto(path.mission, item, response->add_keyframes());
    response->set_next_page_token(found.next_page_token);
    return absl::OkStatus();
  });
}

}  // namespace corbslam::services
