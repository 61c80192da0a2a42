#include "services/map_store_service/streams/wake_timer.h"

#include <utility>

#include "absl/time/clock.h"

namespace corbslam::services {

WakeTimer::~WakeTimer() {
  absl::MutexLock lock(&link_->mutex);
  ++link_->turn;
}

void WakeTimer::Arm(absl::Duration after, std::function<void()> wake) {
  Disarm();
  uint64_t turn = 0;
  {
    absl::MutexLock lock(&link_->mutex);
    turn = link_->turn;
  }
  alarm_ = std::make_unique<grpc::Alarm>();
  const auto ring = [link = link_, turn, wake = std::move(wake)](bool fired) {
    absl::MutexLock lock(&link->mutex);
    if (fired && link->turn == turn) wake();
  };
  alarm_->Set(absl::ToChronoTime(absl::Now() + after), ring);
}

void WakeTimer::Disarm() {
  alarm_.reset();
  absl::MutexLock lock(&link_->mutex);
  ++link_->turn;
}

}  // namespace corbslam::services
