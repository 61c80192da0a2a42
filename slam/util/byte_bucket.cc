#include "slam/util/byte_bucket.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace corbslam {

ByteBucket::ByteBucket(uint64_t bytes_per_second, absl::Duration depth)
    : rate_(static_cast<double>(bytes_per_second)),
      // The depth is one byte at least, or the level would never be positive.
      most_(std::max(1.0, rate_ * absl::ToDoubleSeconds(depth))),
      level_(most_) {}

void ByteBucket::Fill(absl::Time now) {
  if (filled_ != absl::InfinitePast() && now > filled_) {
    level_ = std::min(most_, level_ + rate_ * absl::ToDoubleSeconds(now - filled_));
  }
  filled_ = now;
}

int64_t ByteBucket::Level(absl::Time now) {
  if (!is_bounded()) return std::numeric_limits<int64_t>::max();
  Fill(now);
  return static_cast<int64_t>(std::floor(level_));
}

void ByteBucket::Spend(int64_t bytes, absl::Time now) {
  if (!is_bounded()) return;
  Fill(now);
  level_ = std::min(most_, level_ - static_cast<double>(bytes));
}

absl::Duration ByteBucket::Wait(absl::Time now) {
  if (Level(now) > 0) return absl::ZeroDuration();
  // The wait is rounded up, so that a whole byte is there at its end.
  return absl::Seconds((1 - level_) / rate_) + absl::Microseconds(1);
}

}  // namespace corbslam
