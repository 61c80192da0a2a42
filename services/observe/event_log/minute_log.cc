#include "services/observe/event_log/minute_log.h"

#include <glog/logging.h>

#include <utility>

#include "absl/time/clock.h"

namespace corbslam::services {

MinuteLog::MinuteLog(MakeLine make_line, LogFields who, absl::Duration every)
    : make_line_(std::move(make_line)),
      who_(std::move(who)),
      every_(every),
      thread_([this] { Run(); }) {}

MinuteLog::~MinuteLog() {
  stop_.Notify();
  thread_.join();
}

void MinuteLog::Run() {
  absl::Time begin = absl::Now();
  while (!stop_.WaitForNotificationWithTimeout(every_)) {
    const absl::Time end = absl::Now();
    LOG(INFO) << who_ << make_line_(end - begin);
    begin = end;
  }
}

}  // namespace corbslam::services
