// The time by ROS: the machine's, or what /clock says (use_sim_time).
#ifndef CORBSLAM_CLIENT_AGENT_ROS2_ROS2_CLOCK_H_
#define CORBSLAM_CLIENT_AGENT_ROS2_ROS2_CLOCK_H_

#include <ros2_types.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "client_agent/ros2/ros2_names.h"
#include "client_agent/ros2/ros2_node.h"

namespace corbslam::client_agent {

int64_t Nanoseconds(const builtin_interfaces_msg_dds__Time_& time);
builtin_interfaces_msg_dds__Time_ Ros2Time(int64_t time_ns);

// Thread-safe.
class Ros2Clock {
 public:
  // The node must outlive it, or be stopped before its end.
  static absl::StatusOr<std::unique_ptr<Ros2Clock>> Make(bool use_sim_time, const Ros2Names& names,
                                                         Ros2Node& node);
  // Nullopt: /clock has said nothing yet.
  std::optional<int64_t> Now_ns() const;
  // Null: the machine's own.
  const Ros2Subscription* subscription() const { return subscription_; }

 private:
  static constexpr int64_t kUnknown = INT64_MIN;
  std::atomic<int64_t> simulated_ns_ = kUnknown;
  const Ros2Subscription* subscription_ = nullptr;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_ROS2_ROS2_CLOCK_H_
