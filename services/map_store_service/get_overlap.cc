#include "services/convert/resource_names.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

grpc::ServerUnaryReactor* MapStoreService::GetOverlap(grpc::CallbackServerContext* context,
                                                      const v1::GetOverlapRequest* request,
                                                      v1::Overlap* response) {
  return AnswerOn(pool_, context, [this, request, response]() -> absl::Status {
    ASSIGN_OR_RETURN(const OverlapPath path, ParseOverlapName(request->name()));
    ASSIGN_OR_RETURN(const map_store::OverlapInfo info,
                     store_.GetOverlap(path.mission, path.overlap));
    ToProto(path.mission, info, response);
    return absl::OkStatus();
  });
}

}  // namespace corbslam::services
