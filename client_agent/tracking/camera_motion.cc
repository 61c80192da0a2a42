#include "client_agent/tracking/camera_motion.h"

#include "slam/geometry/lie.h"

namespace corbslam::client_agent {

Rigid3d MotionWithin(int64_t since_ns, const CameraMotion& before) {
  constexpr double kJitter = 1.25;
  if (before.since_ns == 0) return before.camera_from_previous;
  const double times = static_cast<double>(since_ns) / static_cast<double>(before.since_ns);
  const bool is_the_same = times < kJitter && times * kJitter > 1;
  if (is_the_same || times <= 0) return before.camera_from_previous;
  return ExpSE3(times * LogSE3(before.camera_from_previous));
}

}  // namespace corbslam::client_agent
