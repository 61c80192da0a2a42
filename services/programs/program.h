// Holds what all main functions share.
#ifndef CORBSLAM_SERVICES_PROGRAMS_PROGRAM_H_
#define CORBSLAM_SERVICES_PROGRAMS_PROGRAM_H_

#include <CLI/CLI.hpp>
#include <functional>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/synchronization/notification.h"

namespace corbslam::services {

struct Program {
  // Runs until the program is told to stop, or its work is done. INVALID_ARGUMENT is of flags and
  // of the files that they name, before anything has begun: the program ends with kWrongUsage.
  std::function<absl::Status()> run;
  // Returns everything that `run` would refuse before it starts, the files that flags name
  // included; OK statuses are ignored. Starts and changes nothing.
  std::function<std::vector<absl::Status>()> check;
};

// Parses flags into what `app` is bound to (services/command_line), logs which program this is, and
// runs. The exit code (docs/exit_codes.md) is 0, 1 (logged to standard error), kWrongUsage for bad
// flags, or 75 (EX_TEMPFAIL) where `run` was not done in time (DEADLINE_EXCEEDED). With
// --print-config it prints the effective configuration and ends. With --validate-config it only
// checks: 0, or kWrongUsage with a line for each thing that is wrong.
int RunProgram(CLI::App& app, int argc, char** argv, const Program& program);

// Hears SIGTERM and SIGINT, which must be blocked (BlockStopSignals), as long as it lives.
// Thread-safe.
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

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_PROGRAM_H_
