// Equipment for tests of nodes that hear each other.
#ifndef CORBSLAM_CLIENT_AGENT_ROS2_TESTING_ROS2_TEST_NODE_H_
#define CORBSLAM_CLIENT_AGENT_ROS2_TESTING_ROS2_TEST_NODE_H_

#include <unistd.h>

#include <cstdint>
#include <string>

#include "absl/time/clock.h"
#include "client_agent/ros2/ros2_node.h"

namespace corbslam::client_agent {

// Tests that run at the same time hear each other in no domain.
inline Ros2NodeOptions TestNode(const std::string& name) {
  return {
      .name = name, .domain = static_cast<uint32_t>(1 + getpid() % 200), .only_this_host = true};
}

template <typename Condition>
bool Within10s(const Condition& condition) {
  for (int i = 0; i < 200; ++i) {
    if (condition()) return true;
    absl::SleepFor(absl::Milliseconds(50));
  }
  return false;
}

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_ROS2_TESTING_ROS2_TEST_NODE_H_
