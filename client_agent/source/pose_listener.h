// Hears what became of frames: for whoever gave them and wants to know where the robot is.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_POSE_LISTENER_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_POSE_LISTENER_H_

#include <cstdint>
#include <optional>

#include "slam/geometry/rigid3.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

struct FramePose {
  int64_t timestamp_ns = 0;   // The frame's.
  LocalMapId local_map = {};  // Not valid before there is one.
  // Of the sensor's camera, which of a stereo pair that is rectified here is the rectified left
  // one. Absent unless the frame was tracked.
  std::optional<Rigid3d> local_from_camera = std::nullopt;
  // Tracking was lost: there was a local map, and this frame was not found in it.
  bool is_lost = false;
  int points_matched = 0;
  uint64_t dropped = 0;  // Frames so far that were passed over, since newer ones were there.
};

class PoseListener {
 public:
  virtual ~PoseListener() = default;
  // Called from the thread that tracks, after each frame that was tracked or tried; it must return
  // at once.
  virtual void OnPose(const FramePose& pose) = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_POSE_LISTENER_H_
