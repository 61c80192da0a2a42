#include <atomic>
#include <memory>
#include <optional>
#include <utility>

#include "services/agent_service/agent_service.h"
#include "services/agent_service/pulled_stream.h"
#include "services/server/refusal.h"

namespace corbslam::services {

using client_agent::AgentEvent;
using client_agent::AgentEvents;

namespace {

v1::AgentEventKind ToProto(AgentEvent::Kind kind) {
  switch (kind) {
    case AgentEvent::Kind::kLocalMapBegun:
      return v1::AGENT_EVENT_KIND_LOCAL_MAP_BEGUN;
    case AgentEvent::Kind::kLost:
      return v1::AGENT_EVENT_KIND_LOST;
    case AgentEvent::Kind::kRelocalised:
      return v1::AGENT_EVENT_KIND_RELOCALISED;
    case AgentEvent::Kind::kMapCorrected:
      return v1::AGENT_EVENT_KIND_MAP_CORRECTED;
    case AgentEvent::Kind::kGlobalFrameMoved:
      return v1::AGENT_EVENT_KIND_GLOBAL_FRAME_MOVED;
    case AgentEvent::Kind::kMerged:
      return v1::AGENT_EVENT_KIND_MERGED;
    case AgentEvent::Kind::kSplit:
      return v1::AGENT_EVENT_KIND_SPLIT;
    case AgentEvent::Kind::kMissionDeleted:
      return v1::AGENT_EVENT_KIND_MISSION_DELETED;
    case AgentEvent::Kind::kEnded:
      return v1::AGENT_EVENT_KIND_ENDED;
  }
  return v1::AGENT_EVENT_KIND_UNSPECIFIED;
}

void Write(const AgentEvent& event, v1::AgentEvent& proto) {
  proto.set_number(event.number);
  proto.set_time_ns(absl::ToUnixNanos(event.time));
  proto.set_timestamp_ns(event.timestamp_ns);
  proto.set_kind(ToProto(event.kind));
  if (event.local_map.IsValid()) proto.set_local_map(ToString(event.local_map));
  proto.set_epoch(event.epoch);
  proto.set_global_epoch(event.global_epoch);
}

class WatchEventsReactor : public PulledStream<v1::AgentEvent> {
 public:
  WatchEventsReactor(TaskPool& pool, std::shared_ptr<AgentEvents> events, uint64_t after)
      : PulledStream(pool), events_(std::move(events)), known_(after) {
    token_ = events_->AddListener([this] { Want(); });
    Want();
  }

 private:
  bool Make(v1::AgentEvent& response) override {
    const std::optional<uint64_t> ended = events_->ended();
    // The end is the last that is told.
    if (ended.has_value() && known_ == *ended) {
      End();
      return false;
    }
    const std::optional<AgentEvent> event = events_->After(known_);
    if (!event.has_value()) return false;
    known_ = event->number;
    Write(*event, response);
    // There may be more.
    Want();
    return true;
  }
  void Unsubscribe() override { events_->RemoveListener(token_); }

  const std::shared_ptr<AgentEvents> events_;
  uint64_t known_;  // The number of the last event that was written; only Make uses it.
  std::atomic<uint64_t> token_ = 0;
};

}  // namespace

grpc::ServerWriteReactor<v1::AgentEvent>* AgentService::WatchEvents(
    grpc::CallbackServerContext*, const v1::WatchAgentEventsRequest* request) {
  if (options_.events == nullptr) {
    return new RefusedStream<v1::AgentEvent>(
        absl::UnimplementedError("this robot keeps no events"));
  }
  return new WatchEventsReactor(pool_, options_.events, request->after_number());
}

}  // namespace corbslam::services
