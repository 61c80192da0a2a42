#include "services/logging/sync_log.h"

#include <glog/logging.h>

#include <string>

#include "services/logging/log_fields.h"
#include "services/tracing/keyframe_events.h"

namespace corbslam {
namespace {

LogFields Fields(const SessionAgent& agent) {
  return {.mission = agent.mission, .agent = agent.agent};
}

// Its first keyframe stands for a batch.
std::string TraceOf(const MapUpdateBatch& batch) {
  return batch.full_keyframes.empty() ? "" : TraceId(batch.full_keyframes.front().payload->id);
}

}  // namespace

void SyncLog::OnOpened(const SessionAgent& agent) {
  LOG(INFO) << Fields(agent) << "session opened";
}

void SyncLog::OnClosed(const SessionAgent& agent, const absl::Status& status) {
  LOG(INFO) << Fields(agent) << "session ended: " << status;
}

void SyncLog::OnApplied(const SessionAgent& agent, const MapUpdateBatch& batch, absl::Duration,
                        const absl::Status& status) {
  if (status.ok()) return;
  LogFields fields = Fields(agent);
  fields.trace = TraceOf(batch);
  LOG(WARNING) << fields << "batch " << batch.number << " of local map "
               << ToString(batch.local_map) << " is refused: " << status;
}

}  // namespace corbslam
