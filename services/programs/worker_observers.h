// Makes what watches a fusion worker at work: metrics, if the flags say so.
#ifndef CORBSLAM_SERVICES_PROGRAMS_WORKER_OBSERVERS_H_
#define CORBSLAM_SERVICES_PROGRAMS_WORKER_OBSERVERS_H_

#include <prometheus/registry.h>

#include <memory>

#include "absl/status/statusor.h"
#include "services/fusion_worker_service/fusion_worker_service.h"
#include "services/observe/metrics/metrics_endpoint.h"
#include "services/observe/metrics/rpc_metrics.h"
#include "services/programs/observe_flags.h"
#include "slam/exchange/fusion_worker.h"

namespace corbslam::services {

// Watches one fusion worker. One thread uses it. It outlives all that it watches, but for the
// worker that it was given.
class WorkerObservers {
 public:
  explicit WorkerObservers(const ObserveFlags& flags);

  // Returns what it is given, or a watched form of it.
  FusionWorker* Watch(FusionWorker* worker);
  // Returns the observer for ServerOptions.
  RpcObserver* OfCalls() { return metrics_ != nullptr ? &metrics_->rpc : nullptr; }
  // Serves the metrics, and announces the address; null if none are wanted. The result must be
  // destroyed before the service.
  absl::StatusOr<std::unique_ptr<MetricsEndpoint>> Serve(const FusionWorkerService& service);

 private:
  struct Metrics {
    std::shared_ptr<prometheus::Registry> registry = std::make_shared<prometheus::Registry>();
    RpcMetrics rpc{*registry};
    std::unique_ptr<FusionWorker> worker;
  };

  const ObserveFlags flags_;
  std::unique_ptr<Metrics> metrics_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_WORKER_OBSERVERS_H_
