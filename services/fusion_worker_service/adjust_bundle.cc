#include "services/fusion_worker_service/fusion_worker_service.h"
#include "services/fusion_worker_service/work_reactor.h"

namespace corbslam::services {

grpc::ServerBidiReactor<v1::AdjustBundleRequest, v1::AdjustBundleResponse>*
FusionWorkerService::AdjustBundle(grpc::CallbackServerContext* context) {
  using Reactor = WorkReactor<AdjustBundleRequestReader, AdjustBundleResult,
                              v1::AdjustBundleRequest, v1::AdjustBundleResponse>;
  return new Reactor(pool_, queue_, OwnerOf(*context, /*may_wait=*/true), requests_, options_,
                     [this](const AdjustBundleRequest& request, const ProgressCallback& progress) {
                       return worker_.AdjustBundle(request, progress);
                     });
}

}  // namespace corbslam::services
