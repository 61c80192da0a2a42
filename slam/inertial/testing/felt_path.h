// What an IMU feels along a path that a function of time gives: for tests.
#ifndef CORBSLAM_SLAM_INERTIAL_TESTING_FELT_PATH_H_
#define CORBSLAM_SLAM_INERTIAL_TESTING_FELT_PATH_H_

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>

#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"
#include "slam/inertial/imu.h"
#include "slam/inertial/inertial_filter.h"

namespace corbslam {

// world_from_imu at a time, seconds; z is up. It is smooth.
using ImuPath = std::function<Rigid3d(double)>;

// A flight that turns about all axes and comes back after 7 to 13 s.
inline Rigid3d FlownPath(double t_s) {
  Rigid3d pose;
  pose.translation = {1.5 * std::sin(0.9 * t_s), 1.1 * std::sin(0.7 * t_s + 1),
                      0.4 * std::sin(1.3 * t_s)};
  pose.rotation = ExpSO3({0, 0, 0.8 * std::sin(0.5 * t_s)}) *
                  ExpSO3({0.25 * std::sin(1.1 * t_s), 0.2 * std::sin(1.7 * t_s + 0.3), 0});
  return pose;
}

inline Rigid3d PathAt(const ImuPath& path, int64_t time_ns) {
  return path(1e-9 * static_cast<double>(time_ns));
}

// Returns the samples of an interval at `rate_hz`, with white noise by `noise` from `seed` and
// constant biases.
inline ImuSamples FeltAlong(const ImuPath& path, int64_t from_ns, int64_t to_ns, double rate_hz,
                            const ImuNoise& noise, const ImuBiases& biases, uint64_t seed) {
  constexpr double kStep_s = 1e-4;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&](double density) -> Eigen::Vector3d {
    const double sigma = density * std::sqrt(rate_hz);
    return Eigen::Vector3d(normal(random), normal(random), normal(random)) * sigma;
  };
  ImuSamples samples;
  const auto interval_ns = static_cast<int64_t>(1e9 / rate_hz);
  for (int64_t time_ns = from_ns; time_ns <= to_ns; time_ns += interval_ns) {
    const double t_s = 1e-9 * static_cast<double>(time_ns);
    const Rigid3d before = path(t_s - kStep_s);
    const Rigid3d now = path(t_s);
    const Rigid3d after = path(t_s + kStep_s);
    const Eigen::Vector3d acceleration =
        (before.translation - 2 * now.translation + after.translation) / (kStep_s * kStep_s);
    const Eigen::Vector3d up(0, 0, kGravity_mps2);
    samples.push_back(
        {time_ns,
         LogSO3(before.rotation.conjugate() * after.rotation) / (2 * kStep_s) + biases.gyro_rps +
             draw(noise.gyro),
         now.rotation.conjugate() * (acceleration + up) + biases.accel_mps2 + draw(noise.accel)});
  }
  return samples;
}

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_INERTIAL_TESTING_FELT_PATH_H_
