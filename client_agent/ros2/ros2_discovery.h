// What a participant tells of its node: ros_discovery_info, by which ROS 2 lists nodes.
#ifndef CORBSLAM_CLIENT_AGENT_ROS2_ROS2_DISCOVERY_H_
#define CORBSLAM_CLIENT_AGENT_ROS2_ROS2_DISCOVERY_H_

#include <dds/dds.h>

#include <string>
#include <vector>

namespace corbslam::client_agent {

struct Ros2NodeInfo {
  std::string name;
  std::string node_namespace;
  dds_guid_t participant = {};
  std::vector<dds_guid_t> readers;
  std::vector<dds_guid_t> writers;
};

inline constexpr char kDiscoveryTopic[] = "ros_discovery_info";

// Humble's ids have 24 bytes, of which the last 8 are 0; later ones' have 16.
const dds_topic_descriptor_t& DiscoveryType(bool is_humble);
// Returns DDS's code.
dds_return_t WriteDiscovery(dds_entity_t writer, bool is_humble, const Ros2NodeInfo& info);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_ROS2_ROS2_DISCOVERY_H_
