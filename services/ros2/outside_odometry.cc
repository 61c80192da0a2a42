#include "services/ros2/outside_odometry.h"

#include <algorithm>

namespace corbslam::services {
namespace {

Rigid3d Between(const StampedMotion& a, const StampedMotion& b, int64_t timestamp_ns) {
  if (b.timestamp_ns == a.timestamp_ns) return b.motion;
  const double share = static_cast<double>(timestamp_ns - a.timestamp_ns) /
                       static_cast<double>(b.timestamp_ns - a.timestamp_ns);
  return {a.motion.rotation.slerp(share, b.motion.rotation),
          a.motion.translation + share * (b.motion.translation - a.motion.translation)};
}

}  // namespace

std::vector<StampedMotion> OutsideOdometry::AddOdom(int64_t timestamp_ns,
                                                    const Rigid3d& odom_from_base) {
  const absl::MutexLock lock(&mutex_);
  if (!odom_.empty() && timestamp_ns == odom_.back().timestamp_ns) return {};
  // Another clock stamps it: what was before says nothing of what comes.
  if (!odom_.empty() && timestamp_ns < odom_.back().timestamp_ns) odom_.clear();
  odom_.push_back({timestamp_ns, odom_from_base});
  while (timestamp_ns - odom_.front().timestamp_ns > kKept_ns) odom_.pop_front();
  return Match();
}

std::vector<StampedMotion> OutsideOdometry::AddMap(int64_t timestamp_ns,
                                                   const Rigid3d& map_from_base) {
  const absl::MutexLock lock(&mutex_);
  if (!waiting_.empty() && timestamp_ns <= waiting_.back().timestamp_ns) waiting_.clear();
  waiting_.push_back({timestamp_ns, map_from_base});
  if (waiting_.size() > kMostWaiting) {
    waiting_.pop_front();
    ++unmatched_;
  }
  return Match();
}

std::vector<StampedMotion> OutsideOdometry::Match() {
  std::vector<StampedMotion> matched;
  while (!waiting_.empty() && !odom_.empty() &&
         waiting_.front().timestamp_ns <= odom_.back().timestamp_ns) {
    const StampedMotion frame = waiting_.front();
    waiting_.pop_front();
    const auto after = std::lower_bound(
        odom_.begin(), odom_.end(), frame.timestamp_ns,
        [](const StampedMotion& odom, int64_t time_ns) { return odom.timestamp_ns < time_ns; });
    const bool is_exact = after->timestamp_ns == frame.timestamp_ns;
    if (!is_exact && (after == odom_.begin() ||
                      after->timestamp_ns - std::prev(after)->timestamp_ns > kMostGap_ns)) {
      ++unmatched_;
      continue;
    }
    const Rigid3d odom_from_base =
        is_exact ? after->motion : Between(*std::prev(after), *after, frame.timestamp_ns);
    matched.push_back({frame.timestamp_ns, frame.motion * odom_from_base.Inverse()});
  }
  return matched;
}

uint64_t OutsideOdometry::unmatched() const {
  const absl::MutexLock lock(&mutex_);
  uint64_t unmatched = unmatched_;
  for (const StampedMotion& frame : waiting_) {
    if (waiting_.back().timestamp_ns - frame.timestamp_ns > kLongWait_ns) ++unmatched;
  }
  return unmatched;
}

}  // namespace corbslam::services
