#include "services/programs/program.h"

#include <glog/logging.h>
#include <pthread.h>
#include <signal.h>

#include <exception>
#include <map>
#include <string>

#include "services/logging/log_format.h"
#include "services/server/server.h"

namespace corbslam {
namespace {

void AddLogFlag(CLI::App& app, LogFormat& format) {
  app.add_option("--log-format", format, "text: glog's lines; json: an object a line")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, LogFormat>{{"text", LogFormat::kText}, {"json", LogFormat::kJson}}))
      ->default_str("text");
}

}  // namespace

int RunProgram(CLI::App& app, int argc, char** argv, const std::function<absl::Status()>& run) {
  app.set_config("--config", "", "File with flags, in TOML");
  LogFormat format = LogFormat::kText;
  AddLogFlag(app, format);
  CLI11_PARSE(app, argc, argv);
  StartLogging(argv[0], format);
  LOG(INFO) << app.get_name() << " with\n" << app.config_to_str(/*default_also=*/true);
  absl::Status status;
  try {
    status = run();
  } catch (const std::exception& error) {
    status = absl::InternalError(error.what());
  }
  if (!status.ok()) LOG(ERROR) << status;
  EndLogging();
  return status.ok() ? 0 : 1;
}

StopWatcher::StopWatcher()
    : thread_([this] {
        WaitForStopSignal();
        stopped_.Notify();
      }) {}

StopWatcher::~StopWatcher() {
  if (!stopped_.HasBeenNotified()) pthread_kill(thread_.native_handle(), SIGTERM);
  thread_.join();
}

}  // namespace corbslam
