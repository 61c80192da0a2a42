// Takes what other programs want of a robot while it runs, until the next frame.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_AGENT_ORDERS_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_AGENT_ORDERS_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "slam/exchange/uplink.h"
#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

// Bounds that change while the robot runs; nullopt: as it was. 0 is no bound.
struct ChangedLimits {
  std::optional<uint64_t> uplink_bytes_per_second = std::nullopt;
  std::optional<uint64_t> max_map_bytes = std::nullopt;
  std::optional<ShareScope> share = std::nullopt;
};

// What is to be done before a frame is tracked.
struct OrdersForFrame {
  bool mapping_paused = false;
  bool open_local_map = false;
  std::optional<PictureMask> mask = std::nullopt;
  ChangedLimits limits = {};
};

// Thread-safe.
class AgentOrders {
 public:
  // The agent says which pictures it takes, before anybody gives orders.
  void SetCamera(const Camera& camera) {
    absl::MutexLock lock(&mutex_);
    camera_ = camera;
  }

  // FAILED_PRECONDITION for a pause before a new local map that was ordered has its first keyframe:
  // it would stay empty, and the robot would be tracked in nothing.
  absl::Status PauseMapping(bool paused) {
    absl::MutexLock lock(&mutex_);
    if (paused && map_is_empty_) {
      return absl::FailedPreconditionError(
          "the new local map that was ordered has no keyframe yet and would stay empty: pause "
          "mapping once the robot is tracked in it");
    }
    next_.mapping_paused = paused;
    return absl::OkStatus();
  }
  bool mapping_paused() const {
    absl::MutexLock lock(&mutex_);
    return next_.mapping_paused;
  }

  // FAILED_PRECONDITION while mapping is paused.
  absl::Status OpenLocalMap() {
    absl::MutexLock lock(&mutex_);
    if (next_.mapping_paused) {
      return absl::FailedPreconditionError(
          "mapping is paused, and a new local map would stay empty: resume mapping first");
    }
    next_.open_local_map = true;
    map_is_empty_ = true;
    return absl::OkStatus();
  }

  // Says that the camera's pictures were recorded in this size and scaled to what the agent takes
  // (?scale); people's masks are of what was recorded.
  void SetRecordedSize(int width_px, int height_px) {
    absl::MutexLock lock(&mutex_);
    recorded_.width_px = width_px;
    recorded_.height_px = height_px;
  }

  // Takes a mask of the size that was recorded, or of that of the pictures as they are tracked.
  // INVALID_ARGUMENT for another size or type.
  absl::Status SetMask(const PictureMask& mask);
  // Returns what SetMask would; OK before it is known what the camera's pictures are.
  absl::Status CheckMask(const PictureMask& mask) const;

  // Takes the place of limits that no frame has followed yet.
  void SetLimits(const ChangedLimits& limits) {
    absl::MutexLock lock(&mutex_);
    next_.limits = limits;
  }

  // The agent says that a frame was tracked: the local map is not empty.
  void NoteTracked() {
    absl::MutexLock lock(&mutex_);
    if (!next_.open_local_map) map_is_empty_ = false;
  }

  // From now on `listener` is told by Take, on its thread, of all that differs from the frame
  // before. Null: nobody is.
  void SetListener(std::function<void(const OrdersForFrame&)> listener) {
    absl::MutexLock lock(&mutex_);
    listener_ = std::move(listener);
  }

  // Returns what is to be done now; the next call has only what came since.
  OrdersForFrame Take() {
    OrdersForFrame taken;
    std::function<void(const OrdersForFrame&)> tell;
    {
      absl::MutexLock lock(&mutex_);
      const bool paused = next_.mapping_paused;
      taken = std::exchange(next_, {.mapping_paused = paused});
      const bool is_news = taken.open_local_map || taken.mask.has_value() || paused != was_paused_;
      was_paused_ = paused;
      if (is_news) tell = listener_;
    }
    if (tell != nullptr) tell(taken);
    return taken;
  }

 private:
  mutable absl::Mutex mutex_;
  Camera camera_ ABSL_GUARDED_BY(mutex_);
  Camera recorded_ ABSL_GUARDED_BY(mutex_);  // Its size alone; 0: as the camera's.
  OrdersForFrame next_ ABSL_GUARDED_BY(mutex_);
  bool map_is_empty_ ABSL_GUARDED_BY(mutex_) = false;  // Since a new one was ordered.
  bool was_paused_ ABSL_GUARDED_BY(mutex_) = false;    // At the last Take.
  std::function<void(const OrdersForFrame&)> listener_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_AGENT_ORDERS_H_
