// Keeps what an IMU measured while frames were passed over, for the next frame that is taken.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_KEPT_IMU_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_KEPT_IMU_H_

#include <cstdint>
#include <utility>

#include "slam/inertial/imu.h"

namespace corbslam::client_agent {

// No estimator bridges more: what is older is forgotten.
inline constexpr int64_t kLongestKeptImu_ns = 10'000'000'000;

// Frames come in the order of time within a drive; what was measured in one drive says nothing of
// the next. Thread-compatible.
class KeptImu {
 public:
  // Takes what came with a frame that is passed over.
  void Keep(int drive, ImuSamples samples) {
    GiveTo(drive, samples);
    samples_ = std::move(samples);
    drive_ = drive;
  }
  // Puts what is kept before the samples of the next frame, and forgets it.
  void GiveTo(int drive, ImuSamples& samples) {
    if (drive == drive_ && !samples_.empty()) {
      samples_.insert(samples_.end(), samples.begin(), samples.end());
      samples = std::move(samples_);
      Shorten(samples);
    }
    samples_.clear();
  }

 private:
  static void Shorten(ImuSamples& samples) {
    auto first = samples.begin();
    while (samples.back().timestamp_ns - first->timestamp_ns > kLongestKeptImu_ns) ++first;
    samples.erase(samples.begin(), first);
  }

  ImuSamples samples_;
  int drive_ = 0;  // Of `samples_`.
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_KEPT_IMU_H_
