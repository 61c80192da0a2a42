// What tracking says of one frame.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_TRACKING_RESULT_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_TRACKING_RESULT_H_

#include <cstdint>

#include "slam/geometry/rigid3.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

enum class TrackingState {
  kNotInitialised,  // There is no local map yet, or a new one has not begun.
  kTracking,
  kLost,
};

struct TrackingResult {
  int64_t timestamp_ns = 0;
  TrackingState state = TrackingState::kNotInitialised;
  LocalMapId local_map;
  // The rest is valid while tracking.
  Rigid3d camera_from_local;
  KeyframeId reference;
  Rigid3d reference_from_camera;
  // Map points that agree with the pose, and how many of them others made.
  int points_matched = 0;
  int foreign_points_matched = 0;
  bool made_keyframe = false;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_TRACKING_RESULT_H_
