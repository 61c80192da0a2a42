// Says which files a bag is made of.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BAG_FOLDER_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BAG_FOLDER_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace corbslam::client_agent {

struct BagFolder {
  std::vector<std::string> files;  // In the order in which they were recorded.
  // rosbag2's compression of each message by itself: "zstd"; empty: none.
  std::string message_compression;
  std::vector<std::string> notes;  // Files that are missing, or how they were found.
};

// `path` is a file, or a folder: with rosbag2's metadata.yaml the files that it lists, without it
// those that end with .bag, .db3 or .mcap, by name. Errors name the folder, or file and field.
absl::StatusOr<BagFolder> FindBagFiles(const std::string& path);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BAG_FOLDER_H_
