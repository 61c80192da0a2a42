#include "services/programs/store_workers.h"

#include <utility>

#include "services/client/reachability/failure_explainer.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/remote_fusion_worker.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

absl::StatusOr<std::unique_ptr<FusionWorker>> ConnectWorkers(
    const std::vector<std::string>& addresses, const SecurityOptions& security) {
  ASSIGN_OR_RETURN(const auto credentials, MakeChannelCredentials(security));
  std::vector<std::shared_ptr<grpc::Channel>> channels;
  auto explainers = std::make_shared<std::vector<std::unique_ptr<FailureExplainer>>>();
  for (const std::string& address : addresses) {
    channels.push_back(MakeChannel(address, credentials));
    explainers->push_back(
        std::make_unique<FailureExplainer>(ServerTarget{address, kFusionWorkerService, security}));
  }
  RemoteFusionWorkerOptions options;
  options.explain = [explainers](size_t worker, const absl::Status& seen) {
    return explainers->at(worker)->Explain(seen);
  };
  return MakeRemoteFusionWorker(std::move(channels), options);
}

}  // namespace corbslam::services
