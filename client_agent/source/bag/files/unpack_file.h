// Unpacks files that are compressed as a whole.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_UNPACK_FILE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_UNPACK_FILE_H_

#include <string>

#include "absl/status/statusor.h"
#include "client_agent/source/bag/files/bag_bytes.h"

namespace corbslam::client_agent {

// Unpacks zstd into a new file in TMPDIR (/tmp) and returns its path, which the caller removes.
// INVALID_ARGUMENT where it is broken, or unpacks to more than 200 times its size: such a file is
// made to fill disks. UNAVAILABLE where the new one can't be written.
absl::StatusOr<std::string> UnpackZstdFile(const BagBytes& packed);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_UNPACK_FILE_H_
