// Names of a node, its topics and services, as ROS 2 resolves them, and what DDS calls them.
#ifndef CORBSLAM_CLIENT_AGENT_ROS2_ROS2_NAMES_H_
#define CORBSLAM_CLIENT_AGENT_ROS2_ROS2_NAMES_H_

#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/ros2/ros2_arguments.h"

namespace corbslam::client_agent {

// Immutable.
class Ros2Names {
 public:
  // Takes __ns, __node and the rules that are for this node. INVALID_ARGUMENT names the rule and
  // what is wrong with its name.
  static absl::StatusOr<Ros2Names> Make(absl::string_view node,
                                        const std::vector<Ros2Rule>& remaps);

  const std::string& node() const { return node_; }
  const std::string& node_namespace() const { return namespace_; }  // "/", "/alpha".
  std::string full_name() const;                                    // "/alpha/visual_slam".

  // Returns the whole name of a topic or a service: "a/b" is in the namespace, "/a/b" is not,
  // "~/a" is the node's own; then the rules apply, the first that fits.
  std::string Resolve(absl::string_view name) const;

 private:
  std::string Expand(absl::string_view name) const;

  std::string node_;
  std::string namespace_ = "/";
  std::vector<std::pair<std::string, std::string>> remaps_;  // Whole names.
};

// Returns what DDS calls a topic, and the topics of a service's requests and responses.
std::string DdsTopic(absl::string_view topic);
std::string DdsRequestTopic(absl::string_view service);
std::string DdsResponseTopic(absl::string_view service);
// Returns ROS 2's name of a topic of DDS; empty: it is none of ROS 2's topics.
std::string Ros2Topic(absl::string_view dds_topic);
// Returns "sensor_msgs/msg/Image" of "sensor_msgs::msg::dds_::Image_"; another name as it is.
std::string Ros2Type(absl::string_view dds_type);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_ROS2_ROS2_NAMES_H_
