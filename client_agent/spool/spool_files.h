// The file system as the spool sees it: one folder of its own.
#ifndef CORBSLAM_CLIENT_AGENT_SPOOL_SPOOL_FILES_H_
#define CORBSLAM_CLIENT_AGENT_SPOOL_SPOOL_FILES_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam::client_agent {

// The files of one folder. One thread at a time may use it, but for Sync and Read, which may run
// beside all else. Errors name the file: RESOURCE_EXHAUSTED for a full disk or quota, UNAVAILABLE
// for anything else. Names have no folder in them.
class SpoolFiles {
 public:
  virtual ~SpoolFiles() = default;
  // Returns the names in alphabetical order.
  virtual absl::StatusOr<std::vector<std::string>> List() = 0;
  virtual absl::StatusOr<uint64_t> Size(const std::string& name) = 0;
  // Returns fewer bytes where the file ends before.
  virtual absl::StatusOr<std::string> Read(const std::string& name, uint64_t offset,
                                           size_t bytes) = 0;
  // Appends to the file, and creates it where there is none. After an error a part may have been
  // written.
  virtual absl::Status Append(const std::string& name, absl::string_view bytes) = 0;
  virtual absl::Status Truncate(const std::string& name, uint64_t size) = 0;
  // Makes what was written survive a loss of power, the file's name with it.
  virtual absl::Status Sync(const std::string& name) = 0;
  virtual absl::Status Remove(const std::string& name) = 0;
};

// Opens a folder, which is created where it is not there (so that it survives a loss of power), and
// locked as long as the result lives.
// Returns FAILED_PRECONDITION where another process has it.
absl::StatusOr<std::unique_ptr<SpoolFiles>> OpenSpoolFolder(const std::string& path);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SPOOL_SPOOL_FILES_H_
