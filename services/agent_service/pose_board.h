// Holds the newest pose, for any number of readers.
#ifndef CORBSLAM_SERVICES_AGENT_SERVICE_POSE_BOARD_H_
#define CORBSLAM_SERVICES_AGENT_SERVICE_POSE_BOARD_H_

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "corbslam/v1/agent_service.pb.h"

namespace corbslam::services {

// Calls its readers one after the other, from the thread that posts; they must return at once.
// Thread-safe.
class PoseBoard {
 public:
  using Reader = std::function<void(const v1::WatchPoseResponse&)>;

  void Post(v1::WatchPoseResponse pose, uint64_t dropped) {
    absl::MutexLock lock(&mutex_);
    newest_ = std::move(pose);
    dropped_ = dropped;
    for (const auto& [token, reader] : readers_) reader(*newest_);
  }
  uint64_t dropped() const {
    absl::MutexLock lock(&mutex_);
    return dropped_;
  }

  // Adds a reader, which hears the newest pose at once, if there is one. Returns a token for
  // Remove.
  uint64_t Add(Reader reader) {
    absl::MutexLock lock(&mutex_);
    if (newest_) reader(*newest_);
    readers_.emplace(++last_token_, std::move(reader));
    return last_token_;
  }
  // Removes a reader: once this returns, no call is under way and none follows.
  void Remove(uint64_t token) {
    absl::MutexLock lock(&mutex_);
    readers_.erase(token);
  }

 private:
  mutable absl::Mutex mutex_;
  std::optional<v1::WatchPoseResponse> newest_ ABSL_GUARDED_BY(mutex_);
  uint64_t dropped_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t last_token_ ABSL_GUARDED_BY(mutex_) = 0;
  std::map<uint64_t, Reader> readers_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_AGENT_SERVICE_POSE_BOARD_H_
