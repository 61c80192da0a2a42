// Limits how many replays a server works on.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_REPLAY_SLOTS_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_REPLAY_SLOTS_H_

#include <atomic>
#include <cstddef>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"

namespace corbslam::services {

// Counts replays that are made, wait to be made, or are held for callers that read slowly: each
// costs as much as a backup, and then the memory of what it tells. Thread-safe.
class ReplaySlots {
 public:
  explicit ReplaySlots(size_t limit) : limit_(limit) {}

  // Returns what counts as a replay until it is destroyed. RESOURCE_EXHAUSTED if there are as many
  // as the limit.
  absl::StatusOr<std::shared_ptr<const void>> Take() {
    const std::shared_ptr<const void> slot(this, [counted = taken_](const void*) { --*counted; });
    if (++*taken_ <= limit_) return slot;
    return absl::ResourceExhaustedError(absl::StrCat(
        "this server tells ", limit_, " replays already; that is the limit: try again"));
  }

  size_t limit() const { return limit_; }
  size_t taken() const { return *taken_; }

 private:
  const size_t limit_;
  // Shared with the slots, which may outlive this.
  const std::shared_ptr<std::atomic<size_t>> taken_ = std::make_shared<std::atomic<size_t>>(0);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_REPLAY_SLOTS_H_
