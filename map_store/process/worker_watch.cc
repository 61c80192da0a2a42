#include "map_store/process/worker_watch.h"

#include <glog/logging.h>

#include <string>

namespace corbslam::map_store {
namespace {

// Returns whole seconds, for people.
absl::Duration Since(absl::Time begin, absl::Time now) {
  return absl::Trunc(now - begin, absl::Seconds(1));
}

}  // namespace

void WorkerWatch::Note(const absl::Status& status) {
  if (absl::IsCancelled(status)) return;
  const absl::Time now = clock_();
  absl::MutexLock lock(&mutex_);
  if (absl::IsUnavailable(status)) {
    if (!outage_.has_value()) outage_ = WorkerOutage{now, ""};
    outage_->cause = std::string(status.message());
    if (!reminder_.IsDue(now)) return;
    LOG(WARNING) << "no fusion worker takes requests, for " << Since(outage_->begin, now)
                 << " now: " << outage_->cause << "; maps are collected and not fused meanwhile";
    return;
  }
  if (!outage_.has_value()) return;
  LOG(WARNING) << "fusion workers take requests again, after " << Since(outage_->begin, now);
  outage_.reset();
  reminder_.Reset();
}

std::optional<WorkerOutage> WorkerWatch::outage() const {
  absl::MutexLock lock(&mutex_);
  return outage_;
}

}  // namespace corbslam::map_store
