// What a topic promises and wants: ROS 2's quality of service.
#ifndef CORBSLAM_CLIENT_AGENT_ROS2_ROS2_QOS_H_
#define CORBSLAM_CLIENT_AGENT_ROS2_ROS2_QOS_H_

#include <dds/dds.h>

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/ros2/ros2_parameters.h"

namespace corbslam::client_agent {

struct Ros2Qos {
  bool reliable = true;
  bool transient_local = false;  // Who comes late gets what was sent before.
  int depth = 10;                // Of the history.

  friend bool operator==(const Ros2Qos&, const Ros2Qos&) = default;
};

inline constexpr Ros2Qos kSensorData = {.reliable = false, .transient_local = false, .depth = 5};
inline constexpr Ros2Qos kDefaultQos = {};
inline constexpr Ros2Qos kLatched = {.reliable = true, .transient_local = true, .depth = 1};

// Takes a parameter that names a profile: SENSOR_DATA, DEFAULT or SYSTEM_DEFAULT.
absl::Status TakeQosProfile(absl::string_view parameter, Ros2Parameters& parameters, Ros2Qos& qos);
// Takes qos_overrides.TOPIC.KIND.reliability (reliable, best_effort), .durability
// (volatile, transient_local) and .depth; `kind` is "subscription" or "publisher".
absl::Status TakeQosOverrides(const std::string& topic, absl::string_view kind,
                              Ros2Parameters& parameters, Ros2Qos& qos);

using DdsQos = std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)>;
DdsQos MakeDdsQos(const Ros2Qos& qos);
Ros2Qos ReadDdsQos(const dds_qos_t* qos);
// Returns "best effort, volatile".
std::string Describe(const Ros2Qos& qos);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_ROS2_ROS2_QOS_H_
