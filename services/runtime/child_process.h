// Runs one of our own programs as a child: output goes to a log file, its end and cost are noted.
#ifndef CORBSLAM_SERVICES_RUNTIME_CHILD_PROCESS_H_
#define CORBSLAM_SERVICES_RUNTIME_CHILD_PROCESS_H_

#include <sys/types.h>

#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

namespace corbslam::services {

struct ProcessEnd {
  int exit_code = 0;  // 128 + the signal's number if a signal ended it.
  double peak_rss_mb = 0;
  double cpu_s = 0;  // User and system time.
};

// One child, which is killed when this process dies and when the object goes. Thread-safe.
class ChildProcess {
 public:
  // Runs `command` (program, then arguments); standard output and error go to `log_path`.
  // UNAVAILABLE if it can't be started.
  static absl::StatusOr<std::unique_ptr<ChildProcess>> Start(
      const std::string& name, const std::vector<std::string>& command,
      const std::string& log_path);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  const std::string& name() const { return name_; }

  // Returns the HOST:PORT of the line "listening on HOST:PORT". DEADLINE_EXCEEDED if it did not
  // come in time; UNAVAILABLE with the end of the log if the program ended without it.
  absl::StatusOr<std::string> WaitForAddress(absl::Duration timeout);
  // Waits until the child said "finished" or ended; false if it did neither within `timeout`.
  bool WaitUntilFinished(absl::Duration timeout);
  // Returns false if the child still runs after `timeout`.
  bool WaitForEnd(absl::Duration timeout);
  // Returns how the child ended; nullopt while it runs.
  std::optional<ProcessEnd> end() const;
  // Returns OK for exit code 0; otherwise what happened and the last lines of the log. The caller
  // calls it only after the child's end.
  absl::Status EndStatus() const;

  // Asks the child to stop (SIGTERM), kills it after `grace`, and returns how it ended.
  ProcessEnd Stop(absl::Duration grace);

 private:
  ChildProcess(std::string name, std::string log_path, pid_t pid, int output);
  void ReadOutput(int output);
  void NoteLine(absl::string_view line);
  void Reap();
  std::string LastLines() const;

  const std::string name_;
  const std::string log_path_;
  const pid_t pid_;
  mutable absl::Mutex mutex_;
  std::optional<std::string> address_ ABSL_GUARDED_BY(mutex_);
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
  bool output_ended_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<ProcessEnd> end_ ABSL_GUARDED_BY(mutex_);
  std::thread reader_;
  std::thread reaper_;
};

// Returns the path of the program `name` beside the one that runs now. NOT_FOUND names both.
absl::StatusOr<std::string> FindProgramBeside(const std::string& name);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_RUNTIME_CHILD_PROCESS_H_
