// Takes what other programs want of a robot while it runs, until the next frame.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_AGENT_ORDERS_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_AGENT_ORDERS_H_

#include <optional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "slam/sensor/image_check.h"
#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

// What is to be done before a frame is tracked.
struct OrdersForFrame {
  bool mapping_paused = false;
  bool open_local_map = false;
  std::optional<PictureMask> mask = std::nullopt;
};

// Thread-safe.
class AgentOrders {
 public:
  // The agent says which pictures it takes, before anybody gives orders.
  void SetCamera(const Camera& camera) {
    absl::MutexLock lock(&mutex_);
    camera_ = camera;
  }

  void PauseMapping(bool paused) {
    absl::MutexLock lock(&mutex_);
    next_.mapping_paused = paused;
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
    return absl::OkStatus();
  }

  // INVALID_ARGUMENT for a mask of another size than the camera's pictures, or of another type.
  absl::Status SetMask(const PictureMask& mask) {
    absl::MutexLock lock(&mutex_);
    if (const absl::Status fits = CheckMask(mask, camera_); !fits.ok()) return fits;
    next_.mask = mask;
    return absl::OkStatus();
  }

  // Returns what is to be done now; the next call has only what came since.
  OrdersForFrame Take() {
    absl::MutexLock lock(&mutex_);
    const bool paused = next_.mapping_paused;
    return std::exchange(next_, {.mapping_paused = paused});
  }

 private:
  mutable absl::Mutex mutex_;
  Camera camera_ ABSL_GUARDED_BY(mutex_);
  OrdersForFrame next_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_AGENT_ORDERS_H_
