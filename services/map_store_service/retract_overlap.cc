#include <glog/logging.h>

#include "services/convert/resource_names.h"
#include "services/map_store_service/map_store_service.h"
#include "services/observe/logging/log_fields.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

grpc::ServerUnaryReactor* MapStoreService::RetractOverlap(grpc::CallbackServerContext* context,
                                                          const v1::RetractOverlapRequest* request,
                                                          v1::RetractOverlapResponse* response) {
  return AnswerLong(
      long_pool_, context, request->name(), [this, request, response]() -> absl::Status {
        ASSIGN_OR_RETURN(const OverlapPath path, ParseOverlapName(request->name()));
        ASSIGN_OR_RETURN(const std::vector<uint64_t> taken_back,
                         store_.RetractOverlap(path.mission, path.overlap, request->keep_apart()));
        LOG(INFO) << LogFields{.mission = path.mission}
                  << "overlaps taken back: " << taken_back.size() << ", " << path.overlap
                  << " among them";
        for (const uint64_t overlap : taken_back) {
          response->add_overlaps(OverlapName(path.mission, overlap));
        }
        return absl::OkStatus();
      });
}

}  // namespace corbslam::services
