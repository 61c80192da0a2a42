// Reads ROS 2's part of a command line: what stands behind --ros-args.
#ifndef CORBSLAM_CLIENT_AGENT_ROS2_ROS2_ARGUMENTS_H_
#define CORBSLAM_CLIENT_AGENT_ROS2_ROS2_ARGUMENTS_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace corbslam::client_agent {

// FROM:=TO, perhaps for one node alone: NODE:FROM:=TO.
struct Ros2Rule {
  std::string node;  // Empty: for every node.
  std::string from;
  std::string to;
};

struct Ros2Arguments {
  // The program's name and its own flags.
  std::vector<std::string> others;
  std::vector<Ros2Rule> remaps;              // -r, --remap
  std::vector<Ros2Rule> parameters;          // -p, --param; `to` is YAML
  std::vector<std::string> parameter_files;  // --params-file
  std::vector<std::string> without_effect;   // --log-level and others that are ROS 2's own.
};

// ROS 2's part ends with "--" or with the line, and there may be several. INVALID_ARGUMENT names
// the argument and what it wants.
absl::StatusOr<Ros2Arguments> ParseRos2Arguments(const std::vector<std::string>& arguments);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_ROS2_ROS2_ARGUMENTS_H_
