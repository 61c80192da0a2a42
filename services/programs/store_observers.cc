#include "services/programs/store_observers.h"

#include <utility>

#include "services/observe/metrics/lease_collector.h"
#include "services/observe/metrics/measured_fusion_worker.h"
#include "services/observe/metrics/mission_collector.h"
#include "services/observe/metrics/process_collector.h"
#include "services/observe/metrics/security_collector.h"
#include "services/observe/observed_journal.h"
#include "services/server/server.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::Journal;
using map_store::MapStore;

StoreObservers::StoreObservers(const ObserveFlags& flags) : flags_(flags) {
  if (!flags.metrics_listen.empty()) metrics_ = std::make_unique<Metrics>();
}

std::unique_ptr<Journal> StoreObservers::Watch(std::unique_ptr<Journal> journal) {
  if (metrics_ == nullptr) return journal;
  return MakeObservedJournal(std::move(journal), {&metrics_->journal});
}

FusionWorker* StoreObservers::Watch(FusionWorker* worker) {
  if (metrics_ == nullptr || worker == nullptr) return worker;
  metrics_->worker = MakeMeasuredFusionWorker(worker, *metrics_->registry);
  return metrics_->worker.get();
}

std::vector<SyncObserver*> StoreObservers::OfStreams() {
  std::vector<SyncObserver*> observers = {&log_};
  if (metrics_ != nullptr) observers.push_back(&metrics_->ingest);
  return observers;
}

RpcObserver* StoreObservers::OfCalls() { return metrics_ != nullptr ? &metrics_->rpc : nullptr; }

absl::StatusOr<std::unique_ptr<MetricsEndpoint>> StoreObservers::Serve(
    const MapStore& store, const MapStoreService& service,
    const std::shared_ptr<prometheus::Collectable>& more, std::vector<WatchedFolder> folders) {
  if (metrics_ == nullptr) return nullptr;
  ASSIGN_OR_RETURN(auto endpoint,
                   MetricsEndpoint::Start(
                       flags_.metrics_listen,
                       {std::make_shared<ProcessCollector>("map_store"),
                        std::make_shared<SecurityCollector>(), metrics_->registry,
                        std::make_shared<MissionCollector>(&store, &service, &metrics_->ingest),
                        std::make_shared<LeaseCollector>(store.leases()), more,
                        std::make_shared<DiskCollector>(std::move(folders))}));
  AnnounceMetrics(endpoint->address());
  return endpoint;
}

}  // namespace corbslam::services
