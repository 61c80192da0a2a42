// Registers the kind of sources that a driver for ROS 2 publishes: ros2:topics.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_SOURCE_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_SOURCE_H_

#include <memory>

#include "client_agent/live/ros2/ros2_context.h"

namespace corbslam::client_agent {

// Registers "ros2:topics" (docs/ros2.md), which plays the topics that the settings name. The node
// is made when the source is opened.
void RegisterRos2Source(std::shared_ptr<Ros2Context> context);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_SOURCE_H_
