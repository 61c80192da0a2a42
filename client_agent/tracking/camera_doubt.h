// Notices, of a robot that only localises, that its camera is not the one that its rig describes.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_CAMERA_DOUBT_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_CAMERA_DOUBT_H_

#include <cstddef>
#include <deque>

#include "client_agent/tracking/frame.h"
#include "slam/optimisation/camera_fit.h"

namespace corbslam::client_agent {

// What others mapped has its own true size: with another focal length, centre, lens or baseline a
// robot is tracked against it all the same, beside where it is. (A robot that maps bends its own
// map to its camera, so that nothing disagrees.) Not thread-safe.
class CameraDoubt {
 public:
  // One frame of so many is looked at, and of the last looks so many must find another camera. One
  // that is far off has few points that agree, which then seem to fit: with a focal length 20 %
  // short eight looks of 22 found it. Of 81 looks with the right camera (KITTI, TUM, a simulated
  // drive) none did.
  static constexpr int kEachFrames = 10;
  static constexpr size_t kLooks = 20;
  static constexpr int kEnough = 5;

  // Looks at a tracked frame, which is to be associated with others' points that agree with its
  // pose. Warns in the log once, with what fits better and what to do.
  void Look(const Frame& frame);

  bool has_warned() const { return has_warned_; }

 private:
  int frames_ = 0;
  std::deque<bool> looks_;  // The last ones: whether each found another camera.
  bool has_warned_ = false;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_CAMERA_DOUBT_H_
