// Notices, of a robot that only localises, that its camera is not the one that its rig describes.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_CAMERA_DOUBT_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_CAMERA_DOUBT_H_

#include "client_agent/tracking/frame.h"
#include "slam/optimisation/camera_fit.h"

namespace corbslam::client_agent {

// What others mapped has its own true size: with another focal length, centre, lens or baseline a
// robot is tracked against it all the same, beside where it is. (A robot that maps bends its own
// map to its camera, so that nothing disagrees.) Not thread-safe.
class CameraDoubt {
 public:
  // One frame of so many is looked at, and so many in a row must agree on another camera.
  static constexpr int kEachFrames = 10;
  static constexpr int kInARow = 5;

  // Looks at a tracked frame, which is to be associated with others' points that agree with its
  // pose. Warns in the log once, with what fits better and what to do.
  void Look(const Frame& frame);

  bool has_warned() const { return has_warned_; }

 private:
  int frames_ = 0;
  int in_a_row_ = 0;
  bool has_warned_ = false;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_CAMERA_DOUBT_H_
