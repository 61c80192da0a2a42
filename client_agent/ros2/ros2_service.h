// Services of ROS 2, as its middleware on CycloneDDS speaks them: a topic for requests, and one for
// responses, of which each says to which request of whom it belongs. rmw_fastrtps says that
// otherwise: its clients are not understood, nor do they match.
#ifndef CORBSLAM_CLIENT_AGENT_ROS2_ROS2_SERVICE_H_
#define CORBSLAM_CLIENT_AGENT_ROS2_ROS2_SERVICE_H_

#include <functional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client_agent/ros2/ros2_names.h"
#include "client_agent/ros2/ros2_node.h"

namespace corbslam::client_agent {

// What is done returns a word for people, or why it was not done: both become the response's
// message, and OK its success. They are called on the node's thread.
using TriggerCall = std::function<absl::StatusOr<std::string>()>;
using SetBoolCall = std::function<absl::StatusOr<std::string>(bool)>;

// Serves std_srvs/srv/Trigger and std_srvs/srv/SetBool under the resolved name.
absl::Status ServeTrigger(Ros2Node& node, const std::string& service, TriggerCall call);
absl::Status ServeSetBool(Ros2Node& node, const std::string& service, SetBoolCall call);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_ROS2_ROS2_SERVICE_H_
