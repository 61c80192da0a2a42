// Writes to a robot's log what the map store's fusion does to it.
#ifndef CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_ROBOT_EVENTS_H_
#define CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_ROBOT_EVENTS_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "client_agent/agent/agent_events.h"
#include "services/observe/logging/log_fields.h"

namespace corbslam::services {

// Returns the line; nullopt for what others say: that it is lost or found again (no_pose_log.h),
// or moves a little.
std::optional<std::string> DescribeEvent(const client_agent::AgentEvent& event);

// Writes a line for each event, as long as it lives.
class RobotEventLog {
 public:
  RobotEventLog(std::shared_ptr<client_agent::AgentEvents> events, LogFields who);
  ~RobotEventLog();
  RobotEventLog(const RobotEventLog&) = delete;
  RobotEventLog& operator=(const RobotEventLog&) = delete;

 private:
  void Tell();

  const std::shared_ptr<client_agent::AgentEvents> events_;
  const LogFields who_;
  uint64_t told_ = 0;  // Only the listener uses it, one call after the other.
  uint64_t token_ = 0;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_ROBOT_EVENTS_H_
