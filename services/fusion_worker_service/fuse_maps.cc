#include "services/fusion_worker_service/fusion_worker_service.h"
#include "services/fusion_worker_service/work_reactor.h"

namespace corbslam::services {

grpc::ServerBidiReactor<v1::FuseMapsRequest, v1::FuseMapsResponse>* FusionWorkerService::FuseMaps(
    grpc::CallbackServerContext* context) {
  using Reactor =
      WorkReactor<FuseMapsRequestReader, FuseMapsResult, v1::FuseMapsRequest, v1::FuseMapsResponse>;
  return new Reactor(pool_, queue_, OwnerOf(*context, /*may_wait=*/false), requests_, options_,
                     [this](const FuseMapsRequest& request, const ProgressCallback& progress) {
                       return worker_.FuseMaps(request, progress);
                     });
}

}  // namespace corbslam::services
