#include "services/server/self_watch.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

#include "services/runtime/port_probe.h"
#include "services/runtime/service_manager.h"
#include "services/server/served_ports.h"
#include "slam/util/named_thread.h"

namespace corbslam::services {
namespace {

// The manager waits for so many signs of life before it acts.
constexpr int kSignsInTimeout = 3;

}  // namespace

SelfWatch::SelfWatch(SelfWatchOptions options) : options_(std::move(options)) {
  NotifyServiceManager("READY=1");
  thread_ = StartThread("self watch", [this] { Run(); });
}

void SelfWatch::Stop() {
  if (!thread_.joinable()) return;
  NotifyServiceManager("STOPPING=1");
  stop_.Notify();
  thread_.join();
}

absl::Status SelfWatch::status() const {
  absl::MutexLock lock(&mutex_);
  return status_;
}

void SelfWatch::Run() {
  const absl::Duration timeout = WatchdogTimeout();
  const absl::Duration interval = std::min(options_.interval, timeout / kSignsInTimeout);
  const absl::Duration patience = std::min(options_.patience, timeout / kSignsInTimeout);
  do {
    Note(options_.address.empty() ? absl::OkStatus() : ProbePort(options_.address, patience));
    if (status().ok()) NotifyServiceManager("WATCHDOG=1");
  } while (!stop_.WaitForNotificationWithTimeout(interval));
}

void SelfWatch::Note(const absl::Status& probed) {
  failed_ = probed.ok() ? 0 : failed_ + 1;
  if (failed_ > 0 && failed_ < options_.failures) return;
  {
    absl::MutexLock lock(&mutex_);
    if (probed.ok() == status_.ok()) return;
    status_ = probed;
  }
  SetTakesConnections(probed.ok());
  if (probed.ok()) {
    LOG(INFO) << "connections are taken again at " << options_.address;
  } else {
    LOG(ERROR) << "no connection is taken any more: " << probed.message()
               << "; the service manager is told nothing until one is, and may start this anew";
  }
  if (options_.on_change != nullptr) options_.on_change(probed);
}

}  // namespace corbslam::services
