// Notices, of a robot that finds itself in what others mapped, that its camera is not the one that
// its rig describes.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_CAMERA_DOUBT_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_CAMERA_DOUBT_H_

#include <vector>

#include "client_agent/tracking/frame.h"
#include "client_agent/tracking/local_map_view.h"
#include "slam/verification/camera_check.h"

namespace corbslam::client_agent {

// What others mapped has its own true size: with another focal length, centre, lens or baseline a
// robot is tracked against it all the same, beside where it is. (A robot that maps bends its own
// map to its camera, so that nothing disagrees.) Not thread-safe.
class CameraDoubt {
 public:
  // One frame of so many is looked at while tracking goes on, and so many looks in a row must find
  // another camera: a single one may err.
  static constexpr int kEachFrames = 10;
  static constexpr int kEnough = 2;

  // Returns whether a frame that was just found among these points may be believed: each is looked
  // at until one is. Warns in the log once, with what fits better and what to do.
  bool BelievesFound(const Frame& frame, const std::vector<PointInView>& points);
  // Does the same for a frame that tracking went on to.
  bool BelievesTracked(const Frame& frame, const std::vector<PointInView>& points);

  bool has_warned() const { return has_warned_; }

 private:
  bool HasExpectedCamera(const Frame& frame, const std::vector<PointInView>& points);
  void Warn(const Camera& said, const CameraFit& fit);

  int frames_ = 0;
  int in_a_row_ = 0;  // Checks that found another camera.
  bool has_warned_ = false;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_CAMERA_DOUBT_H_
