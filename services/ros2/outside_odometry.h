// Waits for what somebody else's odometry says of the times of frames.
#ifndef CORBSLAM_SERVICES_ROS2_OUTSIDE_ODOMETRY_H_
#define CORBSLAM_SERVICES_ROS2_OUTSIDE_ODOMETRY_H_

#include <cstdint>
#include <deque>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "slam/geometry/rigid3.h"

namespace corbslam::services {

struct StampedMotion {
  int64_t timestamp_ns = 0;
  Rigid3d motion;
};

// Where wheels say odom -> base, map -> odom is what leads from there to the shared pose at the
// same instant: odom is interpolated between two of its messages, and never extrapolated; a frame
// waits for the second one. Thread-safe.
class OutsideOdometry {
 public:
  // Two messages may be so far apart at most to be interpolated between.
  static constexpr int64_t kMostGap_ns = 500'000'000;
  static constexpr size_t kMostWaiting = 300;
  static constexpr int64_t kKept_ns = 10'000'000'000;
  static constexpr int64_t kLongWait_ns = 2'000'000'000;

  // Each returns map_from_odom of the frames for which both are known now, in the order of time.
  std::vector<StampedMotion> AddOdom(int64_t timestamp_ns, const Rigid3d& odom_from_base);
  std::vector<StampedMotion> AddMap(int64_t timestamp_ns, const Rigid3d& map_from_base);

  // Returns how many frames had no odometry around their time, or wait for it for long.
  uint64_t unmatched() const;

 private:
  std::vector<StampedMotion> Match() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  mutable absl::Mutex mutex_;
  std::deque<StampedMotion> odom_ ABSL_GUARDED_BY(mutex_);     // odom_from_base.
  std::deque<StampedMotion> waiting_ ABSL_GUARDED_BY(mutex_);  // map_from_base.
  uint64_t unmatched_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_ROS2_OUTSIDE_ODOMETRY_H_
