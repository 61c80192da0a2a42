#include "slam/inertial/imu_buffer.h"

#include <algorithm>

namespace corbslam {
namespace {

ImuSample Mix(const ImuSample& a, const ImuSample& b, double share_of_b) {
  ImuSample mixed = a;
  mixed.angular_velocity_rps += share_of_b * (b.angular_velocity_rps - a.angular_velocity_rps);
  mixed.specific_force_mps2 += share_of_b * (b.specific_force_mps2 - a.specific_force_mps2);
  return mixed;
}

bool IsBefore(const ImuSample& sample, int64_t time_ns) { return sample.timestamp_ns < time_ns; }

}  // namespace

void ImuBuffer::Add(const ImuSamples& samples) {
  for (const ImuSample& sample : samples) {
    if (samples_.empty() || sample.timestamp_ns > samples_.back().timestamp_ns) {
      samples_.push_back(sample);
    }
  }
}

void ImuBuffer::Forget(int64_t time_ns) {
  while (samples_.size() > 1 && samples_[1].timestamp_ns <= time_ns) samples_.pop_front();
}

ImuSample ImuBuffer::At(int64_t time_ns) const {
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), time_ns, IsBefore);
  if (after == samples_.end()) return samples_.back();
  if (after == samples_.begin()) return samples_.front();
  const ImuSample& before = *std::prev(after);
  const auto whole = static_cast<double>(after->timestamp_ns - before.timestamp_ns);
  return Mix(before, *after, static_cast<double>(time_ns - before.timestamp_ns) / whole);
}

std::vector<ImuStep> ImuBuffer::Between(int64_t from_ns, int64_t to_ns) const {
  std::vector<ImuStep> steps;
  if (samples_.empty() || to_ns <= from_ns) return steps;
  if (from_ns < samples_.front().timestamp_ns) return steps;
  if (to_ns > samples_.back().timestamp_ns + kLongestStep_ns) return steps;
  ImuSample last = At(from_ns);
  last.timestamp_ns = from_ns;
  const auto add = [&](ImuSample next, int64_t time_ns) {
    next.timestamp_ns = time_ns;
    ImuStep step{Mix(last, next, 0.5), 1e-9 * static_cast<double>(time_ns - last.timestamp_ns)};
    step.mean.timestamp_ns = time_ns;
    steps.push_back(step);
    last = next;
  };
  auto next = std::upper_bound(
      samples_.begin(), samples_.end(), from_ns,
      [](int64_t time_ns, const ImuSample& sample) { return time_ns < sample.timestamp_ns; });
  // The gap that `from_ns` lies in counts whole.
  int64_t before_ns = std::prev(next)->timestamp_ns;
  for (; next != samples_.end(); ++next) {
    if (next->timestamp_ns - before_ns > kLongestStep_ns) return {};
    before_ns = next->timestamp_ns;
    if (next->timestamp_ns >= to_ns) break;
    add(*next, next->timestamp_ns);
  }
  if (to_ns > last.timestamp_ns) add(At(to_ns), to_ns);
  return steps;
}

}  // namespace corbslam
