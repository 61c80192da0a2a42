// Counts and times calls of a server, as metrics.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_RPC_METRICS_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_RPC_METRICS_H_

#include <prometheus/counter.h>
#include <prometheus/family.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/container/flat_hash_map.h"
#include "absl/synchronization/mutex.h"
#include "services/server/rpc_observer.h"

namespace corbslam::services {

// Keeps the metrics corbslam_rpc_...: it has series for each method that was called, and for each
// code that it ended with. Thread-safe.
class RpcMetrics : public RpcObserver {
 public:
  // `registry` is not owned and must outlive it.
  explicit RpcMetrics(prometheus::Registry& registry);

  void OnStarted(absl::string_view method) override;
  void OnReceived(absl::string_view method, size_t bytes) override;
  void OnSent(absl::string_view method, size_t bytes) override;
  void OnFinished(absl::string_view method, grpc::StatusCode code, absl::Duration took) override;

 private:
  // Metrics of one method; the registry owns what they point to.
  struct Method {
    prometheus::Gauge* running = nullptr;
    prometheus::Histogram* duration = nullptr;
    prometheus::Histogram* received = nullptr;
    prometheus::Histogram* sent = nullptr;
  };
  Method Find(absl::string_view method) ABSL_LOCKS_EXCLUDED(mutex_);

  prometheus::Family<prometheus::Counter>& calls_;
  prometheus::Family<prometheus::Gauge>& running_;
  prometheus::Family<prometheus::Histogram>& durations_;
  prometheus::Family<prometheus::Histogram>& received_;
  prometheus::Family<prometheus::Histogram>& sent_;
  absl::Mutex mutex_;
  absl::flat_hash_map<std::string, Method> methods_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_RPC_METRICS_H_
