// How a camera moved from one frame to another, and how many frames' time that took.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_CAMERA_MOTION_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_CAMERA_MOTION_H_

#include <cstdint>
#include <deque>

#include "slam/geometry/rigid3.h"

namespace corbslam::client_agent {

// What the camera moved since the last frame that had a pose, in one and the same map.
struct CameraMotion {
  Rigid3d camera_from_previous;
  int64_t since_ns = 0;
};

// Tells frames that were dropped by how long after each other the others came: by the lower
// quartile of the newest intervals, because gaps make them longer, and stamps jitter. Not
// thread-safe.
class FrameRhythm {
 public:
  // Takes the time between a frame and the one before it.
  void Add(int64_t since_ns);

  // Returns how many frames the camera took in that time, those that never came among them: at
  // least 1. A recording that is played backwards has negative times.
  int FramesIn(int64_t since_ns) const;

 private:
  std::deque<int64_t> newest_ns_;
};

// Returns what the camera moves in so many times the time if it goes on as it did, at the same
// velocity along and about its own axes.
Rigid3d GoOnFor(double times, const Rigid3d& camera_from_previous);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_CAMERA_MOTION_H_
