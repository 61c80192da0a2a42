// Makes what watches a map store at work: its log and, if the flags say so, metrics and a trace.
#ifndef CORBSLAM_SERVICES_PROGRAMS_STORE_OBSERVERS_H_
#define CORBSLAM_SERVICES_PROGRAMS_STORE_OBSERVERS_H_

#include <prometheus/registry.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "map_store/store/map_store.h"
#include "services/map_store_service/map_store_service.h"
#include "services/observe/event_log/minute_log.h"
#include "services/observe/event_log/sync_log.h"
#include "services/observe/metrics/disk_collector.h"
#include "services/observe/metrics/ingest_metrics.h"
#include "services/observe/metrics/journal_metrics.h"
#include "services/observe/metrics/metrics_endpoint.h"
#include "services/observe/metrics/rpc_metrics.h"
#include "services/observe/tracing/store_trace.h"
#include "services/programs/observe_flags.h"

namespace corbslam::services {

// Watches one map store. One thread uses it. It outlives all that it watches.
class StoreObservers {
 public:
  // Returns UNAVAILABLE if the trace file can't be written.
  static absl::StatusOr<std::unique_ptr<StoreObservers>> Make(const ObserveFlags& flags);

  // Each returns what it is given, or a watched form of it.
  std::unique_ptr<map_store::Journal> Watch(std::unique_ptr<map_store::Journal> journal);
  FusionWorker* Watch(FusionWorker* worker);
  // Return the observers for MapStoreServiceOptions and ServerOptions.
  std::vector<SyncObserver*> OfStreams();
  RpcObserver* OfCalls();
  // Begins the log's line a minute. `data_dir` is empty where missions are in memory alone. The
  // result must be destroyed before the store.
  std::unique_ptr<MinuteLog> LogEachMinute(map_store::MapStore& store, const std::string& data_dir);
  // Serves the metrics, those of `more` and of the folders' disks among them, and announces the
  // address; null if none are wanted. The result must be destroyed before the store and its
  // service.
  absl::StatusOr<std::unique_ptr<MetricsEndpoint>> Serve(
      const map_store::MapStore& store, const MapStoreService& service,
      const std::shared_ptr<prometheus::Collectable>& more, std::vector<WatchedFolder> folders);

 private:
  struct Metrics {
    std::shared_ptr<prometheus::Registry> registry = std::make_shared<prometheus::Registry>();
    RpcMetrics rpc{*registry};
    IngestMetrics ingest{*registry};
    JournalMetrics journal{*registry};
    std::unique_ptr<FusionWorker> worker;
  };
  struct Trace {
    std::unique_ptr<TraceFile> file;
    StoreTrace store{file.get()};
  };

  explicit StoreObservers(const ObserveFlags& flags) : flags_(flags) {}

  const ObserveFlags flags_;
  SyncLog log_;
  std::unique_ptr<Metrics> metrics_;
  std::unique_ptr<Trace> trace_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_STORE_OBSERVERS_H_
