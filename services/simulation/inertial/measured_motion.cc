#include "services/simulation/inertial/measured_motion.h"

#include <algorithm>
#include <cmath>

#include "slam/geometry/lie.h"

namespace corbslam {
namespace {

// Velocities are differences over twice this: small against a sample's period, and large against
// what rounding a time to nanoseconds does.
constexpr int64_t kReach_ns = 100'000;

double Seconds(int64_t duration_ns) { return 1e-9 * static_cast<double>(duration_ns); }

// Where one sample's period ends and the next one's begins.
struct Boundary {
  int64_t time_ns = 0;
  Eigen::Quaterniond world_from_imu;
  Eigen::Vector3d velocity_mps;
  double velocity_time_s = 0;  // At the ends of the span it lies a little inside.
};

Boundary BoundaryAt(const ImuMotion& motion, const TimeSpan& span, int64_t time_ns) {
  Boundary boundary;
  boundary.time_ns = std::clamp(time_ns, span.first_ns, span.last_ns);
  const int64_t before_ns = std::max(boundary.time_ns - kReach_ns, span.first_ns);
  const int64_t after_ns = std::min(boundary.time_ns + kReach_ns, span.last_ns);
  boundary.world_from_imu = motion(boundary.time_ns).rotation;
  boundary.velocity_mps = (motion(after_ns).translation - motion(before_ns).translation) /
                          Seconds(after_ns - before_ns);
  boundary.velocity_time_s = 0.5 * (Seconds(before_ns) + Seconds(after_ns));
  return boundary;
}

// `samples` a second; halves lie between them.
int64_t TimeOf(double sample, double rate_hz) { return std::llround(1e9 * sample / rate_hz); }

ImuSample Measure(const ImuMotion& motion, int64_t time_ns, const Boundary& from,
                  const Boundary& to) {
  const Eigen::Vector3d gravity(0, kGravity_mps2, 0);
  const Eigen::Vector3d acceleration =
      (to.velocity_mps - from.velocity_mps) / (to.velocity_time_s - from.velocity_time_s);
  ImuSample sample;
  sample.timestamp_ns = time_ns;
  sample.angular_velocity_rps = LogSO3(from.world_from_imu.conjugate() * to.world_from_imu) /
                                Seconds(to.time_ns - from.time_ns);
  sample.specific_force_mps2 = motion(time_ns).rotation.conjugate() * (acceleration - gravity);
  return sample;
}

}  // namespace

ImuSamples MeasureMotion(const ImuMotion& motion, const TimeSpan& span, double rate_hz) {
  ImuSamples samples;
  double number = std::ceil(Seconds(span.first_ns) * rate_hz - 1e-6);
  if (TimeOf(number, rate_hz) < span.first_ns) ++number;
  if (span.last_ns - span.first_ns < 2 * kReach_ns) return samples;
  Boundary from = BoundaryAt(motion, span, TimeOf(number - 0.5, rate_hz));
  for (; TimeOf(number, rate_hz) <= span.last_ns; ++number) {
    const Boundary to = BoundaryAt(motion, span, TimeOf(number + 0.5, rate_hz));
    samples.push_back(Measure(motion, TimeOf(number, rate_hz), from, to));
    from = to;
  }
  return samples;
}

Eigen::Vector3d VelocityAt(const ImuMotion& motion, const TimeSpan& span, int64_t time_ns) {
  return BoundaryAt(motion, span, time_ns).velocity_mps;
}

}  // namespace corbslam
