// Reads rosbag2's SQLite files (.db3).
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_SQLITE_FILE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_SQLITE_FILE_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/source/bag/files/bag_file.h"

namespace corbslam::client_agent {

inline constexpr absl::string_view kSqliteMagic("SQLite format 3\0", 16);

// INVALID_ARGUMENT where it can't be opened, or has not the tables of a bag. `name` stands for the
// file in messages.
absl::StatusOr<std::unique_ptr<BagFile>> OpenSqliteFile(const std::string& path,
                                                        const std::string& name);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_SQLITE_FILE_H_
