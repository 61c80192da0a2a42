// Says when something that goes on is worth another line of the log.
#ifndef CORBSLAM_SLAM_UTIL_RARE_REMINDER_H_
#define CORBSLAM_SLAM_UTIL_RARE_REMINDER_H_

#include <algorithm>

#include "absl/time/time.h"

namespace corbslam {

// A reminder that is due at once, then after a minute, after two more, four more and so on, and in
// the end every quarter of an hour. Not thread-safe.
class RareReminder {
 public:
  // Returns true when it is to be said now. The next time is counted from `now`.
  bool IsDue(absl::Time now) {
    if (now < next_) return false;
    next_ = now + wait_;
    wait_ = std::min(2 * wait_, kLongest);
    return true;
  }
  // What went on is over: the next time is said at once.
  void Reset() { *this = RareReminder(); }

 private:
  static constexpr absl::Duration kFirst = absl::Minutes(1);
  static constexpr absl::Duration kLongest = absl::Minutes(15);

  absl::Time next_ = absl::InfinitePast();
  absl::Duration wait_ = kFirst;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_RARE_REMINDER_H_
