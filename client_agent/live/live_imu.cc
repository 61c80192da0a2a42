#include "client_agent/live/live_imu.h"

#include "client_agent/source/kept_imu.h"
#include "client_agent/source/lists/imu_list.h"

namespace corbslam::client_agent {

void LiveImu::SetOffset(int64_t offset_ns) {
  const absl::MutexLock lock(&mutex_);
  offset_ns_ = offset_ns;
}

void LiveImu::Add(const ImuSamples& samples) {
  const absl::MutexLock lock(&mutex_);
  for (ImuSample sample : samples) {
    sample.timestamp_ns += offset_ns_;
    if (!waiting_.empty() && sample.timestamp_ns <= waiting_.back().timestamp_ns) waiting_.clear();
    waiting_.push_back(sample);
  }
  while (!waiting_.empty() &&
         waiting_.back().timestamp_ns - waiting_.front().timestamp_ns > kLongestKeptImu_ns) {
    // In whole seconds, so that this is rare.
    const int64_t least_ns = waiting_.back().timestamp_ns - kLongestKeptImu_ns + 1'000'000'000;
    auto first = waiting_.begin();
    while (first->timestamp_ns < least_ns) ++first;
    waiting_.erase(waiting_.begin(), first);
  }
}

void LiveImu::Clear() {
  const absl::MutexLock lock(&mutex_);
  waiting_.clear();
  taken_ns_ = std::numeric_limits<int64_t>::min();
}

ImuSamples LiveImu::Take(int64_t until_ns) {
  const absl::MutexLock lock(&mutex_);
  // A frame before the sample that the one before it has got already gets none.
  if (taken_ns_ >= until_ns) return {};
  ImuSamples taken = ImuBetween(waiting_, std::numeric_limits<int64_t>::min(), until_ns);
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(taken.size()));
  if (!taken.empty()) taken_ns_ = taken.back().timestamp_ns;
  return taken;
}

}  // namespace corbslam::client_agent
