// Limits the time within which a caller's next message must come.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_READ_TIMER_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_READ_TIMER_H_

#include <functional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "services/map_store_service/streams/wake_timer.h"

namespace corbslam::services {

// Waits for one message at a time. Only one thread at a time may call Arm and Disarm.
class ReadTimer {
 public:
  // Is called with DEADLINE_EXCEEDED, which says what did not come, on a thread of gRPC's; not once
  // the timer is destroyed. It must not destroy the timer.
  using Overdue = std::function<void(const absl::Status&)>;

  explicit ReadTimer(Overdue overdue) : overdue_(std::move(overdue)) {}

  // Waits for `what` from now on, and for nothing else. If a call of `overdue` is under way, it
  // ends first.
  void Arm(double seconds, const std::string& what);
  void Disarm() { timer_.Disarm(); }

 private:
  const Overdue overdue_;
  WakeTimer timer_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_READ_TIMER_H_
