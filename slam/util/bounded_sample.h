// Statistics of a stream of numbers that may go on for ever.
#ifndef CORBSLAM_SLAM_UTIL_BOUNDED_SAMPLE_H_
#define CORBSLAM_SLAM_UTIL_BOUNDED_SAMPLE_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace corbslam {

// Count, mean and bounds are exact. The values are all of them up to the capacity; from then on a
// sample in which each that came has the same chance to be (Vitter's algorithm R, ACM TOMS 1985),
// so that medians and percentiles stay good. Not thread-safe.
class BoundedSample {
 public:
  static constexpr size_t kCapacity = 65536;

  BoundedSample() = default;
  explicit BoundedSample(size_t capacity) : capacity_(capacity) {}

  void Add(double value) {
    ++count_;
    sum_ += value;
    min_ = std::min(min_, value);
    max_ = std::max(max_, value);
    if (values_.size() < capacity_) {
      values_.push_back(value);
      return;
    }
    const uint64_t place = std::uniform_int_distribution<uint64_t>(0, count_ - 1)(random_);
    if (place < values_.size()) values_[place] = value;
  }

  uint64_t count() const { return count_; }
  // Returns 0 without values, as min() and max() do.
  double mean() const { return count_ == 0 ? 0 : sum_ / static_cast<double>(count_); }
  double min() const { return count_ == 0 ? 0 : min_; }
  double max() const { return count_ == 0 ? 0 : max_; }
  // They are in no order that means anything.
  const std::vector<double>& values() const { return values_; }

 private:
  size_t capacity_ = kCapacity;
  uint64_t count_ = 0;
  double sum_ = 0;
  double min_ = std::numeric_limits<double>::infinity();
  double max_ = -std::numeric_limits<double>::infinity();
  std::vector<double> values_;
  std::mt19937_64 random_{1};
};

// A sample that several threads add to.
class SampleLog {
 public:
  void Add(double value) {
    absl::MutexLock lock(&mutex_);
    sample_.Add(value);
  }
  BoundedSample Copy() const {
    absl::MutexLock lock(&mutex_);
    return sample_;
  }

 private:
  mutable absl::Mutex mutex_;
  BoundedSample sample_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_BOUNDED_SAMPLE_H_
