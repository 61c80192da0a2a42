// Makes what watches a map store at work: its log and, if the flags say so, metrics.
#ifndef CORBSLAM_SERVICES_PROGRAMS_STORE_OBSERVERS_H_
#define CORBSLAM_SERVICES_PROGRAMS_STORE_OBSERVERS_H_

#include <prometheus/registry.h>

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "map_store/store/map_store.h"
#include "services/map_store_service/map_store_service.h"
#include "services/observe/event_log/sync_log.h"
#include "services/observe/metrics/disk_collector.h"
#include "services/observe/metrics/ingest_metrics.h"
#include "services/observe/metrics/journal_metrics.h"
#include "services/observe/metrics/metrics_endpoint.h"
#include "services/observe/metrics/rpc_metrics.h"
#include "services/programs/observe_flags.h"

namespace corbslam::services {

// Watches one map store. One thread uses it. It outlives all that it watches.
class StoreObservers {
 public:
  explicit StoreObservers(const ObserveFlags& flags);

  // Each returns what it is given, or a watched form of it.
  std::unique_ptr<map_store::Journal> Watch(std::unique_ptr<map_store::Journal> journal);
  FusionWorker* Watch(FusionWorker* worker);
  // Return the observers for MapStoreServiceOptions and ServerOptions.
  std::vector<SyncObserver*> OfStreams();
  RpcObserver* OfCalls();
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

  const ObserveFlags flags_;
  SyncLog log_;
  std::unique_ptr<Metrics> metrics_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_STORE_OBSERVERS_H_
