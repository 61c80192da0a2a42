// Gives a run of robots a folder of its own.
#ifndef CORBSLAM_SERVICES_TOOL_RUN_RUN_FOLDER_H_
#define CORBSLAM_SERVICES_TOOL_RUN_RUN_FOLDER_H_

#include <string>
#include <utility>

#include "absl/status/statusor.h"

namespace corbslam::services {

// A folder that one run writes to, for as long as this lives. Not thread-safe.
class RunFolder {
 public:
  // Makes the folder and its `logs`, removes what an earlier run wrote, and notes the command line
  // in logs/command.txt, which says that a run's files are a run's. What no run writes stays.
  // FAILED_PRECONDITION names a file that a run would write and none has written, or says who runs
  // there now; UNAVAILABLE names what can't be made or removed.
  static absl::StatusOr<RunFolder> Take(const std::string& folder, const std::string& command_line);
  RunFolder(RunFolder&& other) noexcept : lock_(std::exchange(other.lock_, -1)) {}
  RunFolder& operator=(RunFolder&&) = delete;
  ~RunFolder();

 private:
  explicit RunFolder(int lock) : lock_(lock) {}

  int lock_;  // Of command.txt, which is open and locked.
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_RUN_RUN_FOLDER_H_
