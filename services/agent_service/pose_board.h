// Holds the newest pose, for any number of readers.
#ifndef CORBSLAM_SERVICES_AGENT_SERVICE_POSE_BOARD_H_
#define CORBSLAM_SERVICES_AGENT_SERVICE_POSE_BOARD_H_

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/tracking/tracking_result.h"
#include "services/agent_service/posted_pose.h"
#include "slam/geometry/rigid3.h"
#include "slam/geometry/same_motion.h"

namespace corbslam::services {

// Calls its readers one after the other, from the thread that posts; they must return at once.
// Thread-safe.
class PoseBoard {
 public:
  using Reader = std::function<void(const PostedPose&)>;
  using Moment = std::chrono::steady_clock::time_point;

  // Returns how often global_from_local has changed so far.
  uint64_t Post(const client_agent::TrackingResult& result, Moment came, uint64_t dropped) {
    absl::MutexLock lock(&mutex_);
    PostedPose pose = newest_.value_or(PostedPose());
    pose.follows_a_pose = pose.result.state == client_agent::TrackingState::kTracking;
    if (!AreEqual(pose.result.global_from_local, result.global_from_local)) ++pose.global_epoch;
    pose.result = result;
    pose.came = came;
    newest_ = std::move(pose);
    dropped_ = dropped;
    for (const auto& [token, readers] : readers_) readers.on_pose(*newest_);
    return newest_->global_epoch;
  }
  uint64_t dropped() const {
    absl::MutexLock lock(&mutex_);
    return dropped_;
  }

  // Says that no pose follows.
  void End() {
    absl::MutexLock lock(&mutex_);
    ended_ = true;
    for (const auto& [token, readers] : readers_) readers.on_end();
  }

  // Adds a reader, which hears the newest pose at once, if there is one, and the end where no pose
  // follows. Returns a token for Remove.
  uint64_t Add(Reader on_pose, std::function<void()> on_end) {
    absl::MutexLock lock(&mutex_);
    if (newest_) on_pose(*newest_);
    if (ended_) on_end();
    readers_.emplace(++last_token_, Readers{std::move(on_pose), std::move(on_end)});
    return last_token_;
  }
  // Removes a reader: once this returns, no call is under way and none follows.
  void Remove(uint64_t token) {
    absl::MutexLock lock(&mutex_);
    readers_.erase(token);
  }

 private:
  struct Readers {
    Reader on_pose;
    std::function<void()> on_end;
  };
  static bool AreEqual(const std::optional<Similarity3d>& a, const std::optional<Similarity3d>& b) {
    if (!a.has_value() || !b.has_value()) return a.has_value() == b.has_value();
    return AreSame(*a, *b);
  }

  mutable absl::Mutex mutex_;
  std::optional<PostedPose> newest_ ABSL_GUARDED_BY(mutex_);
  uint64_t dropped_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t last_token_ ABSL_GUARDED_BY(mutex_) = 0;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  std::map<uint64_t, Readers> readers_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_AGENT_SERVICE_POSE_BOARD_H_
