// Says of files that are no sequences of ours what they are, and how they are played all the same.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_FOREIGN_FILES_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_FOREIGN_FILES_H_

#include <string>

#include "absl/strings/string_view.h"

namespace corbslam::client_agent {

// Returns "a ROS bag: ..., ..." for the name of a file, or the word in front of "bag:FILE", that
// gives away another program's recording; "" for others.
std::string DescribeForeignFile(absl::string_view name);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_FOREIGN_FILES_H_
