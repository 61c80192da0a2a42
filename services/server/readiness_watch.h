// Tells the health service whether a server can do its work now.
#ifndef CORBSLAM_SERVICES_SERVER_READINESS_WATCH_H_
#define CORBSLAM_SERVICES_SERVER_READINESS_WATCH_H_

#include <functional>
#include <thread>

#include "absl/status/status.h"
#include "absl/synchronization/notification.h"
#include "absl/time/time.h"
#include "services/server/server.h"

namespace corbslam::services {

// Asks `check` again and again on a thread of its own, and sets the server's readiness by the
// answer. Changes are in the log. `server` is not owned and must outlive it. Not thread-safe.
class ReadinessWatch {
 public:
  ReadinessWatch(Server* server, std::function<absl::Status()> check,
                 absl::Duration interval = absl::Seconds(1));
  ~ReadinessWatch() { Stop(); }
  ReadinessWatch(const ReadinessWatch&) = delete;
  ReadinessWatch& operator=(const ReadinessWatch&) = delete;

  // Stops asking; readiness stays as it is. One thread calls this, before the server is shut down.
  void Stop();

 private:
  void Run(absl::Duration interval);

  Server* const server_;
  const std::function<absl::Status()> check_;
  absl::Notification stop_;
  std::thread thread_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_READINESS_WATCH_H_
