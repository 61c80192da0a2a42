// Keeps keyframes' codes as they came, for as long as others are likely to be sent them.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_RECENT_CODES_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_RECENT_CODES_H_

#include <cstddef>
#include <deque>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "services/map_store_service/streams/sync_observer.h"

namespace corbslam::services {

// Saves coding features anew, which takes milliseconds a keyframe: each other robot of the mission
// is sent them soon after they came. For a robot that is sent them later they are coded anew
// (KeyframePayload::code). Thread-safe.
class RecentCodes : public SyncObserver {
 public:
  // Most bytes of all codes together; the oldest go first.
  static constexpr size_t kDefaultBytes = 32u << 20;

  explicit RecentCodes(size_t max_bytes = kDefaultBytes) : max_bytes_(max_bytes) {}

  void OnApplied(const SessionAgent&, const MapUpdateBatch& batch, absl::Duration,
                 const absl::Status& status) override;

  size_t bytes() const;

 private:
  const size_t max_bytes_;
  mutable absl::Mutex mutex_;
  std::deque<std::shared_ptr<const std::string>> codes_ ABSL_GUARDED_BY(mutex_);
  size_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_RECENT_CODES_H_
