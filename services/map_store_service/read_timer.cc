#include "services/map_store_service/read_timer.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"

namespace corbslam {

ReadTimer::ReadTimer(Overdue overdue) : link_(std::make_shared<Link>()) {
  absl::MutexLock lock(&link_->mutex);
  link_->overdue = std::move(overdue);
}

ReadTimer::~ReadTimer() {
  absl::MutexLock lock(&link_->mutex);
  link_->overdue = nullptr;
}

void ReadTimer::Arm(double seconds, const std::string& what) {
  Disarm();
  uint64_t turn = 0;
  {
    absl::MutexLock lock(&link_->mutex);
    turn = link_->turn;
  }
  alarm_ = std::make_unique<grpc::Alarm>();
  const auto ring = [link = link_, turn, seconds, what](bool fired) {
    absl::MutexLock lock(&link->mutex);
    if (!fired || link->overdue == nullptr || link->turn != turn) return;
    link->overdue(
        absl::DeadlineExceededError(absl::StrCat(what, " did not come within ", seconds, " s")));
  };
  alarm_->Set(absl::ToChronoTime(absl::Now() + absl::Seconds(seconds)), ring);
}

void ReadTimer::Disarm() {
  alarm_.reset();
  absl::MutexLock lock(&link_->mutex);
  ++link_->turn;
}

}  // namespace corbslam
