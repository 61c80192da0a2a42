// The time within which a caller's next message must come.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_READ_TIMER_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_READ_TIMER_H_

#include <grpcpp/alarm.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"

namespace corbslam {

// Arm and Disarm are for one thread at a time.
class ReadTimer {
 public:
  // Hears DEADLINE_EXCEEDED, saying what did not come, on a thread of gRPC's; not once the timer
  // is destroyed. It must not destroy the timer.
  using Overdue = std::function<void(const absl::Status&)>;

  explicit ReadTimer(Overdue overdue);
  ~ReadTimer();
  ReadTimer(const ReadTimer&) = delete;
  ReadTimer& operator=(const ReadTimer&) = delete;

  // Waits for `what` from now on, and for nothing else. An `overdue` that is under way ends first.
  void Arm(double seconds, const std::string& what);
  void Disarm();

 private:
  // The alarm may go off when the timer is gone.
  struct Link {
    absl::Mutex mutex;
    Overdue overdue ABSL_GUARDED_BY(mutex);
    // Of what is waited for: an alarm may go off while it is being disarmed.
    uint64_t turn ABSL_GUARDED_BY(mutex) = 0;
  };

  const std::shared_ptr<Link> link_;
  std::unique_ptr<grpc::Alarm> alarm_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_READ_TIMER_H_
