#include "services/server/readiness_watch.h"

#include <glog/logging.h>

#include <utility>

#include "slam/util/named_thread.h"

namespace corbslam::services {

ReadinessWatch::ReadinessWatch(Server* server, std::function<absl::Status()> check,
                               absl::Duration interval)
    : server_(server),
      check_(std::move(check)),
      thread_(StartThread("readiness", [this, interval] { Run(interval); })) {}

void ReadinessWatch::Stop() {
  if (!thread_.joinable()) return;
  stop_.Notify();
  thread_.join();
}

void ReadinessWatch::Run(absl::Duration interval) {
  bool was_ready = true;
  do {
    const absl::Status status = check_();
    if (status.ok() != was_ready) {
      if (status.ok()) {
        LOG(INFO) << "ready again";
      } else {
        LOG(WARNING) << "not ready: " << status;
      }
      was_ready = status.ok();
      server_->SetReady(was_ready);
    }
  } while (!stop_.WaitForNotificationWithTimeout(interval));
}

}  // namespace corbslam::services
