#include "services/programs/program.h"

#include <glog/logging.h>
#include <pthread.h>
#include <signal.h>
#include <sys/stat.h>
#include <sysexits.h>

#include <cstdlib>
#include <exception>
#include <iostream>
#include <opencv2/core/utility.hpp>
#include <string>

#include "services/command_line/command_line.h"
#include "services/command_line/setting.h"
#include "services/observe/logging/log_format.h"
#include "services/runtime/file_limit.h"
#include "services/server/server.h"
#include "slam/util/named_thread.h"

namespace corbslam::services {
namespace {

constexpr NamedValues<LogFormat, 2> kLogFormats = {
    {{"text", LogFormat::kText}, {"json", LogFormat::kJson}}};

void AddLogFlag(CLI::App& app, LogFormat& format) {
  AddSetting(app, {"--log-format", OneOf(kLogFormats, &format),
                   "text: glog's lines; json: an object a line"});
}

// Prints a line for each thing that is wrong.
int Validate(const Program& program, const std::string& name) {
  bool valid = true;
  for (const absl::Status& status : program.check()) {
    if (!status.ok()) std::cerr << name << ": " << status.message() << "\n";
    valid = valid && status.ok();
  }
  if (valid) std::cout << name << ": the configuration is valid\n";
  return valid ? 0 : kWrongUsage;
}

int ExitCode(const absl::Status& status) {
  if (status.ok()) return EXIT_SUCCESS;
  // A program says so of its flags and their files alone (Program::run).
  if (absl::IsInvalidArgument(status)) return kWrongUsage;
  return absl::IsDeadlineExceeded(status) ? EX_TEMPFAIL : EXIT_FAILURE;
}

absl::Status RunWithoutExceptions(const Program& program) {
  try {
    return program.run();
  } catch (const std::exception& error) {
    return absl::InternalError(error.what());
  }
}

}  // namespace

int RunProgram(CLI::App& app, int argc, char** argv, const Program& program) {
  LogFormat format = LogFormat::kText;
  AddLogFlag(app, format);
  bool validate_only = false;
  app.add_flag("--validate-config", validate_only,
               "Check all this and the files it names, and exit")
      ->configurable(false);
  bool print_only = false;
  app.add_flag("--print-config", print_only, "Print all settings, and where each was set, and exit")
      ->configurable(false);
  CommandLine command_line(&app, app.get_name());
  if (const auto exit_code = command_line.ParseOrExit(argc, argv); exit_code.has_value()) {
    return *exit_code;
  }
  StartLogging(argv[0], format);
  if (validate_only) return Validate(program, app.get_name());
  if (print_only) {
    std::cout << command_line.DescribeConfiguration();
    return 0;
  }
  LOG(INFO) << app.get_name() << " " << ProgramVersion();
  RaiseFileLimit();
  // Maps, pictures and what robots told are nobody's but the user's that the program runs as.
  umask(S_IRWXG | S_IRWXO);
  // Threads of ours share the work. A pool of OpenCV's beside them waits for a processor that they
  // are on, and they for it: milliseconds in every frame with two of them.
  cv::setNumThreads(1);
  const absl::Status status = RunWithoutExceptions(program);
  if (!status.ok()) LOG(ERROR) << status;
  EndLogging();
  return ExitCode(status);
}

StopWatcher::StopWatcher()
    : thread_(StartThread("stop signals", [this] {
        WaitForStopSignal();
        stopped_.Notify();
      })) {}

StopWatcher::~StopWatcher() {
  if (!stopped_.HasBeenNotified()) pthread_kill(thread_.native_handle(), SIGTERM);
  thread_.join();
}

}  // namespace corbslam::services
