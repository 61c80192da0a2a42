#include "services/fusion_worker_service/fusion_worker_service.h"
#include "services/fusion_worker_service/work_reactor.h"

namespace corbslam::services {

grpc::ServerBidiReactor<v1::LocateFrameRequest, v1::LocateFrameResponse>*
FusionWorkerService::LocateFrame(grpc::CallbackServerContext* context) {
  using Reactor = WorkReactor<LocateFrameRequestReader, LocateFrameResult, v1::LocateFrameRequest,
                              v1::LocateFrameResponse>;
  return new Reactor(pool_, queue_, OwnerOf(*context, /*may_wait=*/false), requests_, options_,
                     [this](const LocateFrameRequest& request, const ProgressCallback& progress) {
                       return worker_.LocateFrame(request, progress);
                     });
}

}  // namespace corbslam::services
