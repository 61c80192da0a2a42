#include "slam/inertial/imu_clock.h"

#include <algorithm>
#include <cmath>

namespace corbslam {
namespace {

using Eigen::Vector3d;

constexpr int64_t kKept_ns = 12'000'000'000;
constexpr int64_t kStep_ns = 4'000'000;
constexpr size_t kLeastTurns = 20;
// Beyond doubt.
constexpr double kSure = 0.9;
constexpr double kBetter = 4;  // Times as much is left over.
// A filter learns less than that by itself.
constexpr int64_t kLeast_ns = 8'000'000;

}  // namespace

void ImuClock::Add(const ImuSamples& samples) {
  for (const ImuSample& sample : samples) {
    if (samples_.empty() || sample.timestamp_ns > samples_.back().timestamp_ns) {
      samples_.push_back(sample);
    }
  }
  while (!samples_.empty() &&
         samples_.front().timestamp_ns < samples_.back().timestamp_ns - kKept_ns) {
    samples_.pop_front();
  }
}

void ImuClock::AddTurn(int64_t from_ns, int64_t to_ns, const Vector3d& rate_rps) {
  turns_.push_back({from_ns, to_ns, rate_rps});
  while (turns_.front().from_ns < to_ns - kKept_ns + kMost_ns) turns_.pop_front();
}

// `turned_rad` is what the IMU had turned at each sample, summed up from the first one on.
double ImuClock::Correlation(const std::vector<Vector3d>& turned_rad, int64_t offset_ns) const {
  const auto turned_at = [&](int64_t time_ns) -> Vector3d {
    const auto after = std::lower_bound(
        samples_.begin(), samples_.end(), time_ns,
        [](const ImuSample& sample, int64_t time) { return sample.timestamp_ns < time; });
    const auto i = static_cast<size_t>(after - samples_.begin());
    const auto whole = static_cast<double>(after->timestamp_ns - std::prev(after)->timestamp_ns);
    const double share = static_cast<double>(time_ns - std::prev(after)->timestamp_ns) / whole;
    return turned_rad[i - 1] + share * (turned_rad[i] - turned_rad[i - 1]);
  };
  double count = 0;
  Vector3d seen_sum = Vector3d::Zero();
  Vector3d felt_sum = Vector3d::Zero();
  double seen_square = 0;
  double felt_square = 0;
  double product = 0;
  for (const Turn& turn : turns_) {
    const int64_t from_ns = turn.from_ns - offset_ns;
    const int64_t to_ns = turn.to_ns - offset_ns;
    if (from_ns <= samples_.front().timestamp_ns || to_ns > samples_.back().timestamp_ns) continue;
    const Vector3d felt =
        (turned_at(to_ns) - turned_at(from_ns)) / (1e-9 * static_cast<double>(to_ns - from_ns));
    count += 1;
    seen_sum += turn.rate_rps;
    felt_sum += felt;
    seen_square += turn.rate_rps.squaredNorm();
    felt_square += felt.squaredNorm();
    product += turn.rate_rps.dot(felt);
  }
  if (count < static_cast<double>(kLeastTurns)) return 0;
  // About the means, so that a gyroscope's bias is nothing.
  const double seen_spread = seen_square - seen_sum.squaredNorm() / count;
  const double felt_spread = felt_square - felt_sum.squaredNorm() / count;
  const double spread = std::sqrt(std::max(0.0, seen_spread * felt_spread));
  return spread > 0 ? (product - seen_sum.dot(felt_sum) / count) / spread : 0;
}

std::optional<ClockFit> ImuClock::Fit() const {
  if (samples_.size() < 2 || turns_.size() < kLeastTurns) return std::nullopt;
  std::vector<Vector3d> turned_rad(samples_.size(), Vector3d::Zero());
  for (size_t i = 1; i < samples_.size(); ++i) {
    const double duration_s =
        1e-9 * static_cast<double>(samples_[i].timestamp_ns - samples_[i - 1].timestamp_ns);
    turned_rad[i] =
        turned_rad[i - 1] +
        duration_s / 2 * (samples_[i].angular_velocity_rps + samples_[i - 1].angular_velocity_rps);
  }
  ClockFit fit;
  fit.correlation_as_stamped = Correlation(turned_rad, 0);
  for (int64_t offset_ns = -kMost_ns; offset_ns <= kMost_ns; offset_ns += kStep_ns) {
    const double correlation = Correlation(turned_rad, offset_ns);
    if (correlation > fit.correlation) fit = {offset_ns, correlation, fit.correlation_as_stamped};
  }
  if (std::abs(fit.offset_ns) == kMost_ns) return std::nullopt;
  // The top of the parabola through the best one and two beside it, far enough for noise to be
  // small in what they differ by.
  constexpr int64_t kBeside_ns = 6 * kStep_ns;
  const double before = Correlation(turned_rad, fit.offset_ns - kBeside_ns);
  const double after = Correlation(turned_rad, fit.offset_ns + kBeside_ns);
  const double bend = before - 2 * fit.correlation + after;
  if (bend < 0 && before > 0 && after > 0) {
    fit.offset_ns +=
        static_cast<int64_t>(0.5 * (before - after) / bend * static_cast<double>(kBeside_ns));
  }
  const bool is_sure =
      fit.correlation > kSure && 1 - fit.correlation_as_stamped > kBetter * (1 - fit.correlation);
  if (!is_sure || std::abs(fit.offset_ns) < kLeast_ns) return std::nullopt;
  return fit;
}

}  // namespace corbslam
