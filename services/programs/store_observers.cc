#include "services/programs/store_observers.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/time/clock.h"
#include "map_store/mission/mission_load.h"
#include "services/observe/event_log/server_minutes.h"
#include "services/observe/metrics/measured_fusion_worker.h"
#include "services/observe/metrics/mission_collector.h"
#include "services/observe/metrics/process_collector.h"
#include "services/observe/metrics/security_collector.h"
#include "services/observe/observed_journal.h"
#include "services/server/process_usage.h"
#include "services/server/server.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::Journal;
using map_store::MapStore;
using map_store::MissionLoad;

namespace {

void AddLoads(const MapStore& store, StoreMinute& minute) {
  uint64_t disk_bytes = 0;
  for (const MissionLoad& load : store.ListLoads()) {
    ++minute.missions;
    minute.robots += load.connected_agents;
    minute.keyframes += load.keyframes;
    minute.waiting_requests += load.waiting.verify + load.waiting.fuse + load.waiting.adjust;
    disk_bytes += load.disk_bytes;
  }
  if (minute.disk.has_value()) minute.disk->used_bytes = disk_bytes;
}

StoreMinute LookAt(MapStore& store, const std::string& data_dir) {
  StoreMinute minute;
  minute.writable = store.CheckWritable();
  minute.damaged_missions = store.ListDamaged().size();
  minute.has_worker = store.has_worker();
  if (const auto outage = store.worker_outage()) {
    minute.outage = {absl::Now() - outage->begin, outage->cause};
  }
  const MapStore::Memory memory = store.memory();
  minute.memory_budget_bytes = memory.budget_bytes;
  minute.refused = memory.refused;
  minute.rss_bytes = GetRssBytes();
  if (!data_dir.empty()) {
    std::error_code error;
    const std::filesystem::space_info space = std::filesystem::space(data_dir, error);
    if (!error) minute.disk = {0, space.available};
  }
  AddLoads(store, minute);
  return minute;
}

}  // namespace

absl::StatusOr<std::unique_ptr<StoreObservers>> StoreObservers::Make(const ObserveFlags& flags) {
  std::unique_ptr<StoreObservers> observers(new StoreObservers(flags));
  if (!flags.metrics_listen.empty()) observers->metrics_ = std::make_unique<Metrics>();
  if (!flags.trace_file.empty()) {
    ASSIGN_OR_RETURN(std::unique_ptr<TraceFile> file,
                     TraceFile::Open(flags.trace_file, "map_store"));
    observers->trace_.reset(new Trace{std::move(file)});
  }
  return observers;
}

std::unique_ptr<Journal> StoreObservers::Watch(std::unique_ptr<Journal> journal) {
  std::vector<JournalObserver*> observers;
  if (metrics_ != nullptr) observers.push_back(&metrics_->journal);
  if (trace_ != nullptr) observers.push_back(&trace_->store);
  if (observers.empty()) return journal;
  return MakeObservedJournal(std::move(journal), std::move(observers));
}

FusionWorker* StoreObservers::Watch(FusionWorker* worker) {
  if (metrics_ == nullptr || worker == nullptr) return worker;
  metrics_->worker = MakeMeasuredFusionWorker(worker, *metrics_->registry);
  return metrics_->worker.get();
}

std::vector<SyncObserver*> StoreObservers::OfStreams() {
  std::vector<SyncObserver*> observers = {&log_};
  if (metrics_ != nullptr) observers.push_back(&metrics_->ingest);
  if (trace_ != nullptr) observers.push_back(&trace_->store);
  return observers;
}

RpcObserver* StoreObservers::OfCalls() { return metrics_ != nullptr ? &metrics_->rpc : nullptr; }

std::unique_ptr<MinuteLog> StoreObservers::LogEachMinute(MapStore& store,
                                                         const std::string& data_dir) {
  // What the last line counted.
  struct Before {
    size_t keyframes = 0;
    uint64_t refused = 0;
  };
  const StoreMinute start = LookAt(store, data_dir);
  return std::make_unique<MinuteLog>(
      [&store, data_dir, before = Before{start.keyframes, start.refused}](absl::Duration) mutable {
        StoreMinute minute = LookAt(store, data_dir);
        const Before now = {minute.keyframes, minute.refused};
        minute.new_keyframes =
            static_cast<int64_t>(now.keyframes) - static_cast<int64_t>(before.keyframes);
        minute.refused = now.refused - before.refused;
        before = now;
        return FormatMinute(minute);
      });
}

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
                        more, std::make_shared<DiskCollector>(std::move(folders))}));
  AnnounceMetrics(endpoint->address());
  return endpoint;
}

}  // namespace corbslam::services
