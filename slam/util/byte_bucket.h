// A budget of bytes a second that is spent in lumps.
#ifndef CORBSLAM_SLAM_UTIL_BYTE_BUCKET_H_
#define CORBSLAM_SLAM_UTIL_BYTE_BUCKET_H_

#include <cstdint>

#include "absl/time/time.h"

namespace corbslam {

// A bucket of bytes that fills at its rate up to what comes in `depth`, and is full at first. More
// may be spent than is in it: the level is negative then, and the debt is paid before anything is
// spent again, so that the mean rate holds however large the lumps are. A clock that jumps back
// fills nothing. Not thread-safe.
class ByteBucket {
 public:
  // A rate of 0 is no bound; the level is always the highest number then.
  explicit ByteBucket(uint64_t bytes_per_second, absl::Duration depth = absl::Seconds(1));

  bool is_bounded() const { return rate_ > 0; }
  // Returns what may be spent now; nothing unless positive.
  int64_t Level(absl::Time now);
  // A negative number gives back what was spent, because it never left.
  void Spend(int64_t bytes, absl::Time now);
  // Returns how long it takes from now until the level is positive.
  absl::Duration Wait(absl::Time now);

 private:
  void Fill(absl::Time now);

  double rate_;
  double most_;
  double level_;
  absl::Time filled_ = absl::InfinitePast();
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_BYTE_BUCKET_H_
