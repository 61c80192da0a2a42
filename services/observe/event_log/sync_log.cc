#include "services/observe/event_log/sync_log.h"

#include <glog/logging.h>

#include <string>

#include "absl/time/clock.h"
#include "services/observe/logging/log_fields.h"

namespace corbslam::services {
namespace {

constexpr size_t kMaxRefused = 1000;

LogFields Fields(const SessionAgent& agent) {
  return {.mission = agent.mission, .agent = agent.agent};
}

}  // namespace

bool SyncLog::IsWorthALine(const SessionAgent& agent) {
  absl::MutexLock lock(&mutex_);
  // A caller that makes up names could fill the map, so it is emptied.
  if (refused_.size() >= kMaxRefused && !refused_.contains(agent)) refused_.clear();
  return refused_[agent].IsDue(absl::Now());
}

void SyncLog::OnOpened(const SessionAgent& agent) {
  {
    absl::MutexLock lock(&mutex_);
    refused_.erase(agent);
  }
  LOG(INFO) << Fields(agent) << "session opened by " << agent.caller;
}

void SyncLog::OnRefused(const SessionAgent& agent, const absl::Status& status) {
  if (!IsWorthALine(agent)) return;
  LOG(WARNING) << Fields(agent) << "session refused to " << agent.caller
               << ", and again when it is asked for: " << status;
}

void SyncLog::OnClosed(const SessionAgent& agent, const absl::Status& status) {
  if (status.ok()) {
    LOG(INFO) << Fields(agent) << "session ended by the robot (" << agent.caller << ")";
  } else {
    LOG(INFO) << Fields(agent) << "session ended (" << agent.caller << "): " << status;
  }
}

void SyncLog::OnApplied(const SessionAgent& agent, const MapUpdateBatch& batch, absl::Duration,
                        const absl::Status& status) {
  if (status.ok()) return;
  LOG(WARNING) << Fields(agent) << "batch " << batch.number << " of local map "
               << ToString(batch.local_map) << " is refused: " << status;
}

}  // namespace corbslam::services
