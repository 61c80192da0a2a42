#include "services/programs/worker_observers.h"

#include <utility>

#include "services/observe/event_log/server_minutes.h"
#include "services/observe/metrics/measured_fusion_worker.h"
#include "services/observe/metrics/process_collector.h"
#include "services/observe/metrics/security_collector.h"
#include "services/observe/metrics/worker_collector.h"
#include "services/server/process_usage.h"
#include "services/server/server.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

WorkerObservers::WorkerObservers(const ObserveFlags& flags) : flags_(flags) {
  if (!flags_.metrics_listen.empty()) metrics_ = std::make_unique<Metrics>();
  tally_ = std::make_unique<CallTally>(v1::FusionWorker::service_full_name(),
                                       metrics_ != nullptr ? &metrics_->rpc : nullptr);
}

FusionWorker* WorkerObservers::Watch(FusionWorker* worker) {
  if (metrics_ == nullptr) return worker;
  metrics_->worker = MakeMeasuredFusionWorker(worker, *metrics_->registry);
  return metrics_->worker.get();
}

std::unique_ptr<MinuteLog> WorkerObservers::LogEachMinute(const FusionWorkerService& service) {
  return std::make_unique<MinuteLog>(
      [this, &service, cpu_s = GetProcessUsage().cpu_s](absl::Duration took) mutable {
        const CallCounts calls = tally_->Take();
        WorkerMinute minute;
        minute.held = service.requests();
        minute.waiting = service.waiting_requests();
        minute.done = calls.done;
        minute.failed = calls.failed;
        minute.cancelled = calls.cancelled;
        const double before_s = std::exchange(cpu_s, GetProcessUsage().cpu_s);
        minute.cpu_s = cpu_s - before_s;
        minute.took = took;
        minute.rss_bytes = GetRssBytes();
        return FormatMinute(minute);
      });
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
