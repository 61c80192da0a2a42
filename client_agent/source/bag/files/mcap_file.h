// Reads MCAP recordings (mcap.dev's specification, version 0).
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_MCAP_FILE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_MCAP_FILE_H_

#include <memory>

#include "absl/strings/string_view.h"
#include "client_agent/source/bag/files/bag_bytes.h"
#include "client_agent/source/bag/files/bag_file.h"

namespace corbslam::client_agent {

inline constexpr absl::string_view kMcapMagic("\x89MCAP0\r\n", 8);

// `file` begins with kMcapMagic.
std::unique_ptr<BagFile> MakeMcapFile(std::unique_ptr<const BagBytes> file);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_MCAP_FILE_H_
