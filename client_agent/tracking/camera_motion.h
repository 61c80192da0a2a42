// How a camera moved from one frame to another.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_CAMERA_MOTION_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_CAMERA_MOTION_H_

#include <cstdint>

#include "slam/geometry/rigid3.h"

namespace corbslam::client_agent {

// What the camera moved since the last frame that had a pose, in one and the same map.
struct CameraMotion {
  Rigid3d camera_from_previous;
  int64_t since_ns = 0;
};

// Returns what the camera moves in `since_ns` if it goes on as it did, camera_from_previous: at the
// same velocity along and about its own axes. Where frames were dropped that is another interval
// than the one before; a difference of less than a quarter is taken for jitter of the stamps, which
// says nothing of the motion. `before` as it is where either interval is none.
Rigid3d MotionWithin(int64_t since_ns, const CameraMotion& before);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_CAMERA_MOTION_H_
