// What else is on the network, and why a topic brings nothing.
#ifndef CORBSLAM_CLIENT_AGENT_ROS2_ROS2_GRAPH_H_
#define CORBSLAM_CLIENT_AGENT_ROS2_ROS2_GRAPH_H_

#include <string>
#include <vector>

#include "client_agent/ros2/ros2_node.h"
#include "client_agent/ros2/ros2_qos.h"

namespace corbslam::client_agent {

struct Ros2Endpoint {
  std::string topic;  // DDS's names.
  std::string type;
  Ros2Qos qos;
};

// Thread-safe.
class Ros2Graph {
 public:
  // The node must outlive it.
  explicit Ros2Graph(const Ros2Node& node);

  // Returns who publishes on the network, this node's own topics among them.
  std::vector<Ros2Endpoint> Publishers() const;

  // Returns a sentence that says why a topic that was subscribed to has brought nothing, and what
  // to do; empty: it has. `name` is what the node calls the topic, for a remapping.
  std::string WhyNothing(const Ros2Subscription& subscription, const std::string& name) const;

 private:
  DdsEntity publications_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_ROS2_ROS2_GRAPH_H_
