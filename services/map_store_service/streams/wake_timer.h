// Calls back when some time has passed.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_WAKE_TIMER_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_WAKE_TIMER_H_

#include <grpcpp/alarm.h>

#include <cstdint>
#include <functional>
#include <memory>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

namespace corbslam::services {

// Calls one function after some time. Only one thread at a time may call Arm and Disarm.
class WakeTimer {
 public:
  WakeTimer() : link_(std::make_shared<Link>()) {}
  ~WakeTimer();
  WakeTimer(const WakeTimer&) = delete;
  WakeTimer& operator=(const WakeTimer&) = delete;

  // Calls `wake` on a thread of gRPC's, and nothing that was to be called before; not once the
  // timer is destroyed. A call that is under way ends first. `wake` must not destroy the timer.
  void Arm(absl::Duration after, std::function<void()> wake);
  void Disarm();

 private:
  // The alarm shares this with the timer, as it may go off when the timer is gone.
  struct Link {
    absl::Mutex mutex;
    // Number of the present wait: an alarm may go off while it is being disarmed.
    uint64_t turn ABSL_GUARDED_BY(mutex) = 0;
  };

  const std::shared_ptr<Link> link_;
  std::unique_ptr<grpc::Alarm> alarm_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_WAKE_TIMER_H_
