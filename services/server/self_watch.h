// Finds out whether a server still takes connections, and lets others know.
#ifndef CORBSLAM_SERVICES_SERVER_SELF_WATCH_H_
#define CORBSLAM_SERVICES_SERVER_SELF_WATCH_H_

#include <functional>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/synchronization/notification.h"
#include "absl/time/time.h"

namespace corbslam::services {

struct SelfWatchOptions {
  // "IP:PORT" of the server; empty: it serves nobody, and works as long as this does.
  std::string address = {};
  absl::Duration interval = absl::Seconds(5);
  absl::Duration patience = absl::Seconds(10);
  // So many probes in a row must fail before the server counts as deaf.
  int failures = 2;
  // Called by its thread when that changes; may be null.
  std::function<void(const absl::Status&)> on_change = nullptr;
};

// Connects to the server again and again on a thread of its own. The log says when it is deaf; the
// service manager hears WATCHDOG=1 as long as it is not, and starts the process again else
// (services/runtime/service_manager.h). It tells the manager READY=1 when it begins, and STOPPING=1
// when it ends. Thread-safe.
class SelfWatch {
 public:
  explicit SelfWatch(SelfWatchOptions options);
  ~SelfWatch() { Stop(); }
  SelfWatch(const SelfWatch&) = delete;
  SelfWatch& operator=(const SelfWatch&) = delete;

  // Ends; one thread calls this, before the server is shut down.
  void Stop();
  // Returns why the server counts as deaf; OK: it does not.
  absl::Status status() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Run();
  void Note(const absl::Status& probed) ABSL_LOCKS_EXCLUDED(mutex_);

  const SelfWatchOptions options_;
  absl::Notification stop_;
  int failed_ = 0;  // Only the thread uses it.
  mutable absl::Mutex mutex_;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_SELF_WATCH_H_
