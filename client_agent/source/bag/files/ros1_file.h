// Reads ROS 1 bags, format 2.0.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_ROS1_FILE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_ROS1_FILE_H_

#include <memory>

#include "absl/strings/string_view.h"
#include "client_agent/source/bag/files/bag_bytes.h"
#include "client_agent/source/bag/files/bag_file.h"

namespace corbslam::client_agent {

inline constexpr absl::string_view kRos1Magic = "#ROSBAG V2.0\n";

// `file` begins with kRos1Magic.
std::unique_ptr<BagFile> MakeRos1File(std::unique_ptr<const BagBytes> file);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_ROS1_FILE_H_
