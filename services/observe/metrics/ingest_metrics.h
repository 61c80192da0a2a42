// Counts what the agents' streams bring, as metrics.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_INGEST_METRICS_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_INGEST_METRICS_H_

#include <prometheus/counter.h>
#include <prometheus/family.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "services/map_store_service/streams/sync_observer.h"
#include "services/observe/metrics/families.h"

namespace corbslam::services {

// Counts batches and acknowledgements in the registry, and what is counted for each agent here. An
// agent's series go when its mission is deleted, and a while after it has ended its last session
// itself, so that Prometheus has seen them at their end. An agent whose session broke is missing:
// its series stay until it comes back, or for a week. Thread-safe.
class IngestMetrics : public SyncObserver {
 public:
  static constexpr absl::Duration kKeptFor = absl::Minutes(5);
  static constexpr absl::Duration kMissedFor = absl::Hours(7 * 24);
  // Of more agents that are missing, those that have been so for longest are not told beyond
  // kKeptFor.
  static constexpr size_t kMostMissing = 1000;

  // `registry` is not owned and must outlive it.
  explicit IngestMetrics(prometheus::Registry& registry,
                         std::function<absl::Time()> clock = &absl::Now);

  void OnOpened(const SessionAgent& agent) override;
  void OnClosed(const SessionAgent& agent, const absl::Status& status) override;
  void OnReceived(const SessionAgent& agent, size_t bytes) override;
  void OnSent(const SessionAgent& agent, size_t bytes) override;
  void OnBatch(const SessionAgent& agent, const MapUpdateBatch& batch) override;
  void OnApplied(const SessionAgent& agent, const MapUpdateBatch& batch, absl::Duration took,
                 const absl::Status& status) override;

  void OnShareDelayed(const SessionAgent& agent, size_t bytes, absl::Duration waited) override;

  // Adds the agents' series. `missions` are all that exist.
  void AddAgents(const std::set<std::string>& missions, Families& families);

 private:
  struct AgentCounts {
    bool is_missing() const { return sessions == 0 && broke; }

    int sessions = 0;
    // The last session was not ended by the agent itself.
    bool broke = false;
    absl::Time last_closed;
    uint64_t received_bytes = 0;
    uint64_t sent_bytes = 0;
    uint64_t batches = 0;
    uint64_t keyframes = 0;
    uint64_t delayed_bytes = 0;
    absl::Duration delay;
  };
  void DropGone(const std::set<std::string>& missions) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Returns when the last session of an agent ended, at the latest, that is missing and told no
  // more.
  absl::Time FindMissedSince() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::function<absl::Time()> clock_;
  prometheus::Family<prometheus::Counter>& batches_;
  prometheus::Family<prometheus::Counter>& sessions_;
  prometheus::Gauge& batches_waiting_;
  prometheus::Histogram& acknowledgements_;
  absl::Mutex mutex_;
  std::map<SessionAgent, AgentCounts> agents_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_INGEST_METRICS_H_
