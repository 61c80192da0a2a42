// Finds out by how much an IMU's stamps are late against a camera's, where that is more than a
// filter can learn: by when both turned.
#ifndef CORBSLAM_SLAM_INERTIAL_IMU_CLOCK_H_
#define CORBSLAM_SLAM_INERTIAL_IMU_CLOCK_H_

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "slam/inertial/imu.h"

namespace corbslam {

struct ClockFit {
  // What is added to the IMU's stamps to get the camera's times.
  int64_t offset_ns = 0;
  // Correlation of both rates of turning with this offset, and with the stamps as they are.
  double correlation = 0;
  double correlation_as_stamped = 0;
};

// Keeps the newest seconds. Not thread-safe.
class ImuClock {
 public:
  // Offsets are sought up to this.
  static constexpr int64_t kMost_ns = 500'000'000;

  void Add(const ImuSamples& samples);
  // Takes how fast the camera turned between two times of its clock, about the IMU's axes by the
  // calibration.
  void AddTurn(int64_t from_ns, int64_t to_ns, const Eigen::Vector3d& rate_rps);

  // Returns the samples that are kept, as they are stamped.
  ImuSamples samples() const { return {samples_.begin(), samples_.end()}; }
  // Returns the offset with which both turn alike at the same times, beyond doubt and to some
  // milliseconds; nullopt where they turned too evenly or about other axes, or where the stamps as
  // they are do nearly as well.
  std::optional<ClockFit> Fit() const;

 private:
  struct Turn {
    int64_t from_ns;
    int64_t to_ns;
    Eigen::Vector3d rate_rps;
  };
  double Correlation(const std::vector<Eigen::Vector3d>& turned_rad, int64_t offset_ns) const;

  std::deque<ImuSample> samples_;
  std::deque<Turn> turns_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_INERTIAL_IMU_CLOCK_H_
