#include "services/fusion_worker_service/fusion_worker_service.h"
#include "services/fusion_worker_service/work_reactor.h"

namespace corbslam::services {

grpc::ServerBidiReactor<v1::VerifyOverlapRequest, v1::VerifyOverlapResponse>*
FusionWorkerService::VerifyOverlap(grpc::CallbackServerContext* context) {
  using Reactor = WorkReactor<VerifyOverlapRequestReader, VerifyOverlapResult,
                              v1::VerifyOverlapRequest, v1::VerifyOverlapResponse>;
  return new Reactor(pool_, queue_, OwnerOf(*context, /*may_wait=*/false), requests_, options_,
                     [this](const VerifyOverlapRequest& request, const ProgressCallback& progress) {
                       return worker_.VerifyOverlap(request, progress);
                     });
}

}  // namespace corbslam::services
