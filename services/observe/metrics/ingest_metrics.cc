#include "services/observe/metrics/ingest_metrics.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "services/observe/metrics/buckets.h"

namespace corbslam::services {
namespace {

prometheus::Labels CodeLabel(const absl::Status& status) {
  return {{"code", absl::StatusCodeToString(status.code())}};
}

}  // namespace

IngestMetrics::IngestMetrics(prometheus::Registry& registry, std::function<absl::Time()> clock)
    : clock_(std::move(clock)),
      batches_(prometheus::BuildCounter()
                   .Name("corbslam_batches_total")
                   .Help("Batches of the agents, by what became of them; OK: acknowledged.")
                   .Register(registry)),
      sessions_(prometheus::BuildCounter()
                    .Name("corbslam_sessions_ended_total")
                    .Help("Sessions of the agents that ended, by the status that they ended with.")
                    .Register(registry)),
      batches_waiting_(prometheus::BuildGauge()
                           .Name("corbslam_batches_waiting")
                           .Help("Batches that are received and not yet acknowledged or refused.")
                           .Register(registry)
                           .Add({})),
      acknowledgements_(
          prometheus::BuildHistogram()
              .Name("corbslam_acknowledgement_duration_seconds")
              .Help("From a batch's last byte to its acknowledgement, the journal included.")
              .Register(registry)
              .Add({}, ShortTimes_s())) {
  // These series are there from the first scrape on, so that rates begin at zero.
  batches_.Add(CodeLabel(absl::OkStatus()));
  sessions_.Add(CodeLabel(absl::OkStatus()));
}

void IngestMetrics::OnOpened(const SessionAgent& agent) {
  absl::MutexLock lock(&mutex_);
  ++agents_[agent].sessions;
}

void IngestMetrics::OnClosed(const SessionAgent& agent, const absl::Status& status) {
  sessions_.Add(CodeLabel(status)).Increment();
  absl::MutexLock lock(&mutex_);
  AgentCounts& counts = agents_[agent];
  --counts.sessions;
  counts.broke = !status.ok();
  counts.last_closed = clock_();
}

void IngestMetrics::OnReceived(const SessionAgent& agent, size_t bytes) {
  absl::MutexLock lock(&mutex_);
  agents_[agent].received_bytes += bytes;
}

void IngestMetrics::OnSent(const SessionAgent& agent, size_t bytes) {
  absl::MutexLock lock(&mutex_);
  agents_[agent].sent_bytes += bytes;
}

void IngestMetrics::OnBatch(const SessionAgent&, const MapUpdateBatch&) {
  batches_waiting_.Increment();
}

void IngestMetrics::OnApplied(const SessionAgent& agent, const MapUpdateBatch& batch,
                              absl::Duration took, const absl::Status& status) {
  batches_waiting_.Decrement();
  batches_.Add(CodeLabel(status)).Increment();
  if (!status.ok()) return;
  acknowledgements_.Observe(absl::ToDoubleSeconds(took));
  absl::MutexLock lock(&mutex_);
  AgentCounts& counts = agents_[agent];
  ++counts.batches;
  counts.keyframes += batch.full_keyframes.size();
}

void IngestMetrics::OnShareDelayed(const SessionAgent& agent, size_t bytes, absl::Duration waited) {
  absl::MutexLock lock(&mutex_);
  AgentCounts& counts = agents_[agent];
  counts.delayed_bytes += bytes;
  counts.delay += waited;
}

absl::Time IngestMetrics::FindMissedSince() const {
  std::vector<absl::Time> closed;
  for (const auto& [agent, counts] : agents_) {
    if (counts.is_missing()) closed.push_back(counts.last_closed);
  }
  const absl::Time week_ago = clock_() - kMissedFor;
  if (closed.size() <= kMostMissing) return week_ago;
  const auto first_told = closed.end() - kMostMissing;
  std::ranges::nth_element(closed, first_told);
  return std::max(week_ago, *first_told);
}

void IngestMetrics::DropGone(const std::set<std::string>& missions) {
  const absl::Time kept_since = clock_() - kKeptFor;
  const absl::Time missed_since = std::min(FindMissedSince(), kept_since);
  std::erase_if(agents_, [&](const auto& entry) {
    const auto& [agent, counts] = entry;
    if (counts.sessions > 0) return false;
    if (!missions.contains(agent.mission)) return true;
    return counts.last_closed < (counts.broke ? missed_since : kept_since);
  });
}

void IngestMetrics::AddAgents(const std::set<std::string>& missions, Families& families) {
  absl::MutexLock lock(&mutex_);
  DropGone(missions);
  for (const auto& [agent, counts] : agents_) {
    if (!missions.contains(agent.mission)) continue;
    const MetricLabels labels = {{"mission", agent.mission}, {"agent", agent.agent}};
    families.Gauge("corbslam_agent_connected", "Whether the agent has a session now.",
                   counts.sessions > 0, labels);
    families.Gauge("corbslam_agent_missing",
                   "Whether the agent's last session broke, and none has begun since.",
                   counts.is_missing(), labels);
    families.Counter("corbslam_agent_received_bytes_total", "Bytes of the agent's messages.",
                     static_cast<double>(counts.received_bytes), labels);
    families.Counter("corbslam_agent_sent_bytes_total", "Bytes of the messages to the agent.",
                     static_cast<double>(counts.sent_bytes), labels);
    families.Counter("corbslam_agent_batches_total", "Batches of the agent acknowledged.",
                     static_cast<double>(counts.batches), labels);
    families.Counter("corbslam_agent_keyframes_total",
                     "Keyframes in the agent's acknowledged batches.",
                     static_cast<double>(counts.keyframes), labels);
    families.Counter("corbslam_agent_delayed_bytes_total",
                     "Bytes of shared updates that waited for the budget of the agent's link.",
                     static_cast<double>(counts.delayed_bytes), labels);
    families.Counter("corbslam_agent_delay_seconds_total", "For how long they waited, together.",
                     absl::ToDoubleSeconds(counts.delay), labels);
  }
}

}  // namespace corbslam::services
