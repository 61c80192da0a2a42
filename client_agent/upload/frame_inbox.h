// Holds frames on their way from tracking to those who tell the map store of them.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_FRAME_INBOX_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_FRAME_INBOX_H_

#include <cstdint>
#include <utility>
#include <variant>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "slam/exchange/map_update.h"

namespace corbslam::client_agent {

// The inbox is thread-safe. Its lock is held for moments only: tracking waits for nobody who makes
// batches.
class FrameInbox {
 public:
  struct LostFrame {
    int64_t timestamp_ns = 0;
  };
  using Frame = std::variant<TrackedFrame, LostFrame>;

  void Add(Frame frame, absl::Time now) {
    absl::MutexLock lock(&mutex_);
    frames_.push_back(std::move(frame));
    last_added_ = now;
  }
  // Returns all frames that were added since the last call, in order.
  std::vector<Frame> Take() {
    absl::MutexLock lock(&mutex_);
    return std::exchange(frames_, {});
  }
  // Returns when the last frame was added; before the first one, infinitely long ago.
  absl::Time last_added() const {
    absl::MutexLock lock(&mutex_);
    return last_added_;
  }

 private:
  mutable absl::Mutex mutex_;
  std::vector<Frame> frames_ ABSL_GUARDED_BY(mutex_);
  absl::Time last_added_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_FRAME_INBOX_H_
