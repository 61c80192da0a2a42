// One of our own programs, run as a child: its output to a log file, its end and what it used.
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

namespace corbslam {

struct ProcessEnd {
  int exit_code = 0;  // 128 + the signal's number when a signal ended it.
  double peak_rss_mb = 0;
  double cpu_s = 0;  // User and system.
};

// Thread-safe. A child is killed when this process dies, and when its object goes.
class ChildProcess {
 public:
  // Runs `command` (program, then arguments); standard output and error go to `log_path`.
  // UNAVAILABLE when it can't be started.
  static absl::StatusOr<std::unique_ptr<ChildProcess>> Start(
      const std::string& name, const std::vector<std::string>& command,
      const std::string& log_path);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  const std::string& name() const { return name_; }

  // The HOST:PORT of the line "listening on HOST:PORT". DEADLINE_EXCEEDED, or UNAVAILABLE with the
  // end of the log when the program ended without it.
  absl::StatusOr<std::string> WaitForAddress(absl::Duration timeout);
  // Waits until it said "finished" or ended; false when it did neither within `timeout`.
  bool WaitUntilFinished(absl::Duration timeout);
  // False when it still runs after `timeout`.
  bool WaitForEnd(absl::Duration timeout);
  // Once it has ended.
  std::optional<ProcessEnd> end() const;
  // OK for exit code 0; otherwise what happened and the last lines of the log. Only after its end.
  absl::Status EndStatus() const;

  // Asks it to stop (SIGTERM), kills it after `grace`, and returns how it ended.
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

// Path of the program `name` beside the one that runs now. NOT_FOUND names both.
absl::StatusOr<std::string> FindProgramBeside(const std::string& name);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_RUNTIME_CHILD_PROCESS_H_
