#include <algorithm>
#include <cstdint>
#include <memory>

#include "services/convert/features.h"
#include "services/convert/geometry.h"
#include "services/convert/work/locate_frame.h"
#include "services/fusion_worker_service/fusion_worker_service.h"
#include "services/server/refusal.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

grpc::ServerUnaryReactor* FusionWorkerService::ExtractFeatures(
    grpc::CallbackServerContext* context, const v1::ExtractFeaturesRequest* request,
    v1::ExtractFeaturesResponse* response) {
  if (++requests_ > options_.max_requests) {
    --requests_;
    return RefuseCall(
        context, absl::UnavailableError(
                     absl::StrCat("this worker has ", options_.max_requests, " requests already")));
  }
  // The place is free once nothing holds this any more, also where nobody waits for the answer.
  const std::shared_ptr<void> place(nullptr, [this](void*) {
    --requests_;
    if (options_.when_done != nullptr) options_.when_done();
  });
  return AnswerOn(pool_, context, [this, place, request, response]() -> absl::Status {
    ASSIGN_OR_RETURN(ExtractFeaturesRequest work, FromProto(request->picture()));
    if (request->features() > 0) {
      work.features = static_cast<int>(std::min(request->features(), uint32_t{0x7fffffff}));
    }
    ASSIGN_OR_RETURN(const ExtractFeaturesResult result, worker_.ExtractFeatures(work));
    ToProto(result.features, response->mutable_features());
    ToProto(result.camera, response->mutable_camera());
    return absl::OkStatus();
  });
}

}  // namespace corbslam::services
