#include "services/programs/worker_observers.h"

#include "services/observe/metrics/measured_fusion_worker.h"
#include "services/observe/metrics/process_collector.h"
#include "services/observe/metrics/security_collector.h"
#include "services/observe/metrics/worker_collector.h"
#include "services/server/server.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

WorkerObservers::WorkerObservers(const ObserveFlags& flags) : flags_(flags) {
  if (!flags_.metrics_listen.empty()) metrics_ = std::make_unique<Metrics>();
}

FusionWorker* WorkerObservers::Watch(FusionWorker* worker) {
  if (metrics_ == nullptr) return worker;
  metrics_->worker = MakeMeasuredFusionWorker(worker, *metrics_->registry);
  return metrics_->worker.get();
}

absl::StatusOr<std::unique_ptr<MetricsEndpoint>> WorkerObservers::Serve(
    const FusionWorkerService& service) {
  if (metrics_ == nullptr) return nullptr;
  ASSIGN_OR_RETURN(auto endpoint, MetricsEndpoint::Start(
                                      flags_.metrics_listen,
                                      {std::make_shared<ProcessCollector>("fusion_worker"),
                                       std::make_shared<SecurityCollector>(), metrics_->registry,
                                       std::make_shared<WorkerCollector>(&service)}));
  AnnounceMetrics(endpoint->address());
  return endpoint;
}

}  // namespace corbslam::services
