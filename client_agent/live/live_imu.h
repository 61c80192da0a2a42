// Holds what a live camera's IMU measured until a frame is taken.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_LIVE_IMU_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_LIVE_IMU_H_

#include <cstdint>
#include <limits>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "slam/inertial/imu.h"

namespace corbslam::client_agent {

// The newest ten seconds are kept. Frames that nobody takes lose no samples: the next one has them.
// Thread-safe: the camera's thread adds, one thread takes.
class LiveImu {
 public:
  // `offset_ns` is added to every stamp (ImuCalibration::time_offset_s). Set before the first
  // sample.
  void SetOffset(int64_t offset_ns) ABSL_LOCKS_EXCLUDED(mutex_);
  // Samples come in the order of time. Where time goes back another clock stamps them: those before
  // are forgotten.
  void Add(const ImuSamples& samples) ABSL_LOCKS_EXCLUDED(mutex_);
  // Forgets everything.
  void Clear() ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns each sample once: those that were not taken yet, up to the first at or after `until_ns`
  // (ImuBetween).
  ImuSamples Take(int64_t until_ns) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  absl::Mutex mutex_;
  int64_t offset_ns_ ABSL_GUARDED_BY(mutex_) = 0;
  ImuSamples waiting_ ABSL_GUARDED_BY(mutex_);
  // Of the sample that was taken last.
  int64_t taken_ns_ ABSL_GUARDED_BY(mutex_) = std::numeric_limits<int64_t>::min();
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_LIVE_IMU_H_
