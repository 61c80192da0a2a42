#include "services/convert/resource_names.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/paging.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::LocalMapInfo;

grpc::ServerUnaryReactor* MapStoreService::GetLocalMap(grpc::CallbackServerContext* context,
                                                       const v1::GetLocalMapRequest* request,
                                                       v1::LocalMap* response) {
  return AnswerOn(pool_, context, [this, request, response]() -> absl::Status {
    ASSIGN_OR_RETURN(const LocalMapPath path,
                     ParseLocalMapName(request->name(), /*may_be_all=*/false));
    ASSIGN_OR_RETURN(const LocalMapInfo info, store_.GetLocalMap(path.mission, path.local_map));
    ToProto(path.mission, info, response);
    return absl::OkStatus();
  });
}

}  // namespace corbslam::services
