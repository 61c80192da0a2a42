// What the mains share.
#ifndef CORBSLAM_SERVICES_PROGRAMS_PROGRAM_H_
#define CORBSLAM_SERVICES_PROGRAMS_PROGRAM_H_

#include <CLI/CLI.hpp>
#include <functional>
#include <thread>

#include "absl/status/status.h"
#include "absl/synchronization/notification.h"

namespace corbslam {

// Parses flags into what `app` is bound to, logs the effective configuration, and runs. The exit
// code is 0, 1 (logged to standard error) or CLI11's for bad flags. Every flag can also stand in a
// file that --config names.
int RunProgram(CLI::App& app, int argc, char** argv, const std::function<absl::Status()>& run);

// Hears SIGTERM and SIGINT, which must be blocked (BlockStopSignals), as long as it lives.
class StopWatcher {
 public:
  StopWatcher();
  ~StopWatcher();
  StopWatcher(const StopWatcher&) = delete;
  StopWatcher& operator=(const StopWatcher&) = delete;

  const absl::Notification& stopped() const { return stopped_; }

 private:
  absl::Notification stopped_;
  std::thread thread_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_PROGRAMS_PROGRAM_H_
