#include "services/observe/event_log/robot_events.h"

#include <glog/logging.h>

#include <utility>

#include "absl/strings/str_cat.h"

namespace corbslam::services {

using client_agent::AgentEvent;
using client_agent::AgentEvents;

std::optional<std::string> DescribeEvent(const AgentEvent& event) {
  const std::string map = absl::StrCat("local map ", ToString(event.local_map));
  switch (event.kind) {
    case AgentEvent::Kind::kMerged:
      return absl::StrCat("merged: ", map, " lies in one frame with others' maps");
    case AgentEvent::Kind::kSplit:
      return absl::StrCat("split: ", map,
                          " no longer lies in one frame with others' maps; a merge was taken back");
    case AgentEvent::Kind::kMissionDeleted:
      return "the mission was deleted at the map store";
    case AgentEvent::Kind::kLocalMapBegun:
    case AgentEvent::Kind::kLost:
    case AgentEvent::Kind::kRelocalised:
    case AgentEvent::Kind::kMapCorrected:
    case AgentEvent::Kind::kGlobalFrameMoved:
    case AgentEvent::Kind::kEnded:
      break;
  }
  return std::nullopt;
}

RobotEventLog::RobotEventLog(std::shared_ptr<AgentEvents> events, LogFields who)
    : events_(std::move(events)), who_(std::move(who)) {
  token_ = events_->AddListener([this] { Tell(); });
}

RobotEventLog::~RobotEventLog() { events_->RemoveListener(token_); }

void RobotEventLog::Tell() {
  while (const std::optional<AgentEvent> event = events_->After(told_)) {
    told_ = event->number;
    const std::optional<std::string> line = DescribeEvent(*event);
    if (!line.has_value()) continue;
    if (event->kind == AgentEvent::Kind::kMerged) {
      LOG(INFO) << who_ << *line;
    } else {
      LOG(WARNING) << who_ << *line;
    }
  }
}

}  // namespace corbslam::services
