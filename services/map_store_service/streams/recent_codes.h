// Keeps keyframes' codes as they came, for as long as others are likely to be sent them.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_RECENT_CODES_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_RECENT_CODES_H_

#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "services/map_store_service/streams/sync_observer.h"

namespace corbslam::services {

// Saves coding features anew, which takes milliseconds a keyframe: each other robot of the mission
// is sent them soon after they came. For a robot that is sent them later they are coded anew
// (KeyframePayload::code). Codes of a mission without sessions are sent to nobody, and go at once.
// Thread-safe.
class RecentCodes : public SyncObserver {
 public:
  // Most bytes of all codes together; the oldest go first.
  static constexpr size_t kDefaultBytes = 32u << 20;
  // Codes that are older go when others come.
  static constexpr absl::Duration kMaxAge = absl::Minutes(1);

  explicit RecentCodes(size_t max_bytes = kDefaultBytes,
                       std::function<absl::Time()> clock = &absl::Now)
      : max_bytes_(max_bytes), clock_(std::move(clock)) {}

  void OnOpened(const SessionAgent& who) override;
  void OnClosed(const SessionAgent& who, const absl::Status&) override;
  void OnApplied(const SessionAgent& who, const MapUpdateBatch& batch, absl::Duration,
                 const absl::Status& status) override;

  size_t bytes() const;

 private:
  struct Code {
    std::string mission;
    absl::Time came;
    std::shared_ptr<const std::string> bytes;
  };

  const size_t max_bytes_;
  const std::function<absl::Time()> clock_;
  mutable absl::Mutex mutex_;
  // Open sessions by mission; there is one at least of each that is named.
  std::map<std::string, size_t> sessions_ ABSL_GUARDED_BY(mutex_);
  std::deque<Code> codes_ ABSL_GUARDED_BY(mutex_);
  size_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_RECENT_CODES_H_
