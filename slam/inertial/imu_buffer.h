// Keeps the newest samples of an IMU, and gives what it felt between two times.
#ifndef CORBSLAM_SLAM_INERTIAL_IMU_BUFFER_H_
#define CORBSLAM_SLAM_INERTIAL_IMU_BUFFER_H_

#include <cstdint>
#include <deque>
#include <vector>

#include "slam/inertial/imu.h"

namespace corbslam {

// What an IMU felt in the mean of an interval; its time is the interval's end.
struct ImuStep {
  ImuSample mean;
  double duration_s = 0;
};

// Not thread-safe.
class ImuBuffer {
 public:
  // Two samples further apart have a gap between them; and the newest one is taken to last for so
  // long.
  static constexpr int64_t kLongestStep_ns = 50'000'000;

  // Leaves out samples that are not after the newest one.
  void Add(const ImuSamples& samples);
  // Forgets what is before `time_ns`, less one sample.
  void Forget(int64_t time_ns);

  // Returns the newest sample's time; 0 before the first.
  int64_t newest_ns() const { return samples_.empty() ? 0 : samples_.back().timestamp_ns; }
  // Returns the steps from one time to a later one; none where samples are missing there: before
  // the first one, in a gap, or for longer than kLongestStep_ns after the last.
  std::vector<ImuStep> Between(int64_t from_ns, int64_t to_ns) const;

 private:
  // Between two samples by their times; that of the nearest one outside.
  ImuSample At(int64_t time_ns) const;

  std::deque<ImuSample> samples_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_INERTIAL_IMU_BUFFER_H_
