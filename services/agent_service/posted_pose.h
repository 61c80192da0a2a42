// What watchers are told of a frame.
#ifndef CORBSLAM_SERVICES_AGENT_SERVICE_POSTED_POSE_H_
#define CORBSLAM_SERVICES_AGENT_SERVICE_POSTED_POSE_H_

#include <chrono>
#include <cstdint>
#include <optional>

#include "client_agent/tracking/tracking_result.h"
#include "corbslam/v1/agent_service.pb.h"
#include "slam/camera/recorded_camera.h"
#include "slam/geometry/rigid3.h"

namespace corbslam::services {

struct PostedPose {
  client_agent::TrackingResult result;
  uint64_t global_epoch = 0;
  std::chrono::steady_clock::time_point came = {};  // When the frame did.
  // The frame before had a pose, too.
  bool follows_a_pose = false;
};

// Returns the message for those who want poses of `poses_of`; `camera_from_wanted` leads from it to
// the camera of the result; nullopt: it is that camera.
v1::WatchPoseResponse ToProto(const PostedPose& posted, PosesOf poses_of,
                              const std::optional<Rigid3d>& camera_from_wanted);

v1::TrackingState ToProto(client_agent::TrackingState state);
v1::WhyNoPose ToProto(client_agent::WhyNoPose why);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_AGENT_SERVICE_POSTED_POSE_H_
