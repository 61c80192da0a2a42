// Says how a robot is doing, as lines of /diagnostics.
#ifndef CORBSLAM_SERVICES_ROS2_ROS2_DIAGNOSIS_H_
#define CORBSLAM_SERVICES_ROS2_ROS2_DIAGNOSIS_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client_agent/agent/agent.h"
#include "services/ros2/ros2_outputs.h"
#include "services/ros2/silence_watch.h"

namespace corbslam::services {

struct Ros2Facts {
  bool has_begun = false;  // The camera is there.
  bool has_ended = false;
  std::string waits_for;  // Why it has not begun, or what was left out last.
  std::string image_topics[2];
  FlowCounts flow;
  Silence silence = Silence::kNone;
  double silent_for_s = 0;
  client_agent::AgentStatus agent;
  uint64_t dropped = 0;                                // Frames that came too fast.
  std::optional<double> latency_ms = std::nullopt;     // From the newest picture to its pose.
  std::optional<absl::Status> session = std::nullopt;  // Nullopt: there is no map store.
  // By how much the newest frame is stamped later than the time by ROS is.
  std::optional<double> stamp_ahead_s = std::nullopt;
  bool use_sim_time = false;
  // Somebody else publishes a transform that this node publishes: "odom -> base_link".
  std::vector<std::string> conflicts;
  // Frames without odometry of somebody else around them, where map -> odom hangs on it.
  uint64_t unmatched = 0;
};

// The first line is the tracking's.
std::vector<Ros2Diagnosis> Diagnose(const Ros2Facts& facts);

// Returns a sentence for a silence; empty for none.
std::string Describe(Silence silence, double silent_for_s, const std::string (&topics)[2]);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_ROS2_ROS2_DIAGNOSIS_H_
