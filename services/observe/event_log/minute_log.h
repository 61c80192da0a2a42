// Writes a line to the log every minute.
#ifndef CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_MINUTE_LOG_H_
#define CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_MINUTE_LOG_H_

#include <functional>
#include <string>
#include <thread>

#include "absl/synchronization/notification.h"
#include "absl/time/time.h"
#include "services/observe/logging/log_fields.h"

namespace corbslam::services {

// Has a thread of its own, so that lines come while nothing else happens. Thread-safe.
class MinuteLog {
 public:
  // Returns the next line; `took` is the time since the last one. What it uses must outlive the
  // log.
  using MakeLine = std::function<std::string(absl::Duration took)>;

  explicit MinuteLog(MakeLine make_line, LogFields who = {},
                     absl::Duration every = absl::Minutes(1));
  // The destructor waits for a line that is being made.
  ~MinuteLog();
  MinuteLog(const MinuteLog&) = delete;
  MinuteLog& operator=(const MinuteLog&) = delete;

 private:
  void Run();

  const MakeLine make_line_;
  const LogFields who_;
  const absl::Duration every_;
  absl::Notification stop_;
  std::thread thread_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_MINUTE_LOG_H_
