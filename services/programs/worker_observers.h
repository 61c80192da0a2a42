// Who watches a fusion worker at work: metrics, if the flags say so.
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

namespace corbslam {

// One thread. Outlives all that it watches, but for the worker that it was given.
class WorkerObservers {
 public:
  explicit WorkerObservers(const ObserveFlags& flags);

  // What it is given, or the same watched.
  FusionWorker* Watch(FusionWorker* worker);
  // For ServerOptions.
  RpcObserver* OfCalls();
  // Serves the metrics, and announces where; null where none are wanted. To be destroyed before the
  // service.
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

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_PROGRAMS_WORKER_OBSERVERS_H_
