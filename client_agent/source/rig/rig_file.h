// Reads and writes rig files (docs/rig.md).
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_RIG_RIG_FILE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_RIG_RIG_FILE_H_

#include <string>

#include "absl/status/statusor.h"
#include "client_agent/source/rig/rig.h"

namespace corbslam::client_agent {

// NOT_FOUND where the file can't be opened. INVALID_ARGUMENT names the file and the line or field:
// what is no YAML, an unknown field, one that is missing, a value that no camera has. A mask's path
// that is not absolute is beside the file.
absl::StatusOr<Rig> ReadRigFile(const std::string& path);

// Reads a rig file's text that came another way; `name` stands for the file in messages. A mask is
// INVALID_ARGUMENT, since a text has no folder.
absl::StatusOr<Rig> ReadRigText(const std::string& text, const std::string& name);

// Returns the file's text, with a comment that says what it is and, in `origin`, what of.
// ReadRigFile gives the same rig; motions up to rounding.
std::string FormatRig(const Rig& rig, const std::string& origin);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_RIG_RIG_FILE_H_
