// The parameters of a node, from ROS 2's files of parameters and from its command line.
#ifndef CORBSLAM_CLIENT_AGENT_ROS2_ROS2_PARAMETERS_H_
#define CORBSLAM_CLIENT_AGENT_ROS2_ROS2_PARAMETERS_H_

#include <map>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/ros2/ros2_arguments.h"
#include "client_agent/ros2/ros2_names.h"

namespace corbslam::client_agent {

// Values as YAML; names of nested ones are joined by '.'.
class Ros2Parameters {
 public:
  // Files come first, in their order, then what the command line says. Of a file what stands for
  // this node is taken: below its whole name, its name, or a pattern with /** or /*. Errors name
  // file and parameter.
  static absl::StatusOr<Ros2Parameters> Read(const Ros2Arguments& arguments,
                                             const Ros2Names& names);

  // Each sets `value` where the parameter is given. INVALID_ARGUMENT names it, its value and what
  // it wants.
  absl::Status Take(absl::string_view name, bool& value);
  absl::Status Take(absl::string_view name, double& value, double least, double most);
  absl::Status Take(absl::string_view name, int& value, int least, int most);
  absl::Status Take(absl::string_view name, std::string& value);
  absl::Status Take(absl::string_view name, std::vector<double>& value, size_t count);
  // Takes one of the words.
  absl::Status Take(absl::string_view name, std::string& value,
                    const std::vector<absl::string_view>& words);
  // Returns the names that are given and begin so.
  std::vector<std::string> Beginning(absl::string_view prefix) const;

  // INVALID_ARGUMENT names the parameters that nobody took, and those that there are.
  absl::Status CheckAllTaken() const;

 private:
  const std::string* Find(absl::string_view name);

  struct Given {
    std::string value;
    std::string from;  // For messages: the file, or the command line.
  };
  absl::Status Wrong(absl::string_view name, absl::string_view wanted) const;

  std::map<std::string, Given> given_;
  std::set<std::string> known_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_ROS2_ROS2_PARAMETERS_H_
