#include "services/map_store_service/streams/share_pacer.h"

#include <algorithm>

namespace corbslam::services {
namespace {

// An update of fewer bytes is mostly its own frame; the debt is paid afterwards.
constexpr int64_t kLeastBytes = 2048;

}  // namespace

absl::Duration SharePacer::Wait(absl::Time now) {
  const absl::Duration wait = bucket_.Wait(now);
  if (wait > absl::ZeroDuration() && !waiting_since_) waiting_since_ = now;
  return wait;
}

size_t SharePacer::Allow(size_t most, absl::Time now) {
  return std::min(most, static_cast<size_t>(std::max(kLeastBytes, bucket_.Level(now))));
}

absl::Duration SharePacer::NoteSent(size_t bytes, absl::Time now) {
  bucket_.Spend(static_cast<int64_t>(bytes), now);
  const absl::Duration waited =
      waiting_since_ ? std::max(absl::ZeroDuration(), now - *waiting_since_) : absl::ZeroDuration();
  waiting_since_.reset();
  return waited;
}

}  // namespace corbslam::services
