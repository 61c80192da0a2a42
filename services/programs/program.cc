#include "services/programs/program.h"

#include <glog/logging.h>
#include <pthread.h>
#include <signal.h>

#include <exception>

#include "services/server/server.h"

namespace corbslam {

int RunProgram(CLI::App& app, int argc, char** argv, const std::function<absl::Status()>& run) {
  app.set_config("--config", "", "File with flags, in TOML");
  CLI11_PARSE(app, argc, argv);
  FLAGS_logtostderr = true;
  google::InitGoogleLogging(argv[0]);
  LOG(INFO) << app.get_name() << " with\n" << app.config_to_str(/*default_also=*/true);
  absl::Status status;
  try {
    status = run();
  } catch (const std::exception& error) {
    status = absl::InternalError(error.what());
  }
  if (!status.ok()) LOG(ERROR) << status;
  google::ShutdownGoogleLogging();
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
