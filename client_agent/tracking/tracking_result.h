// What tracking says of one frame.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_TRACKING_RESULT_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_TRACKING_RESULT_H_

#include <cstdint>
#include <optional>

#include "client_agent/tracking/camera_motion.h"
#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"
#include "slam/inertial/inertial_motion.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

enum class TrackingState {
  kNotInitialised,  // There is no local map yet, or a new one has not begun.
  kTracking,
  kLost,
};

// Why a frame has no pose.
enum class WhyNoPose {
  kHasOne,
  kFewKeypoints,    // Fewer corners than a map begins with: dark, blurred, covered or bare.
  kFewDepths,       // Too few of them have a depth.
  kLittleParallax,  // One camera alone has not moved aside yet, so that nothing has a depth.
  kMappingBusy,     // Mapping still works on earlier frames.
  kMappingPaused,   // There is no map, and none may begin.
  kNotRecognised,   // The picture is good, and the map doesn't show this place, or too differently.
  kAnotherCamera,   // What others mapped shows this place, to another camera than the rig's.
};

// Where an IMU takes a frame to be that pictures give no pose of.
struct ReckonedPose {
  Rigid3d camera_from_local;
  // In the local map, in its axes (InMapAxes).
  Matrix6d covariance = Matrix6d::Identity();
  // What the camera moved since the last frame that had a pose.
  CameraMotion motion;
};

struct TrackingResult {
  int64_t timestamp_ns = 0;
  TrackingState state = TrackingState::kNotInitialised;
  WhyNoPose why_no_pose = WhyNoPose::kHasOne;
  LocalMapId local_map;
  // Number of corrections of the local map that the pose follows (GuardedMap::corrections).
  uint64_t corrections = 0;
  // The rest is valid while tracking.
  Rigid3d camera_from_local;
  KeyframeId reference;
  Rigid3d reference_from_camera;
  // Map points that agree with the pose, and how many of them others made.
  int points_matched = 0;
  int foreign_points_matched = 0;
  // Map points that the pose has in view.
  int points_in_view = 0;
  // The covariance of the camera's pose in the local map, in its axes (InMapAxes); nullopt where
  // the points don't determine it.
  std::optional<Matrix6d> covariance;
  // Nullopt for the first frame of a local map, but where another one handed over to it.
  std::optional<CameraMotion> motion;
  bool made_keyframe = false;
  // True: the frame before became a keyframe after its result was returned.
  bool follows_keyframe = false;
  // True: the picture was not searched for features (Tracker::Follow).
  bool was_followed = false;
  // True: no picture said how the camera came here since it was lost, but the IMU. The map goes on
  // here.
  bool was_bridged = false;
  // Absent while tracking, and where nobody knows.
  std::optional<ReckonedPose> reckoned;
  // Where gravity pulls, in the camera's axes; nullopt where there is no IMU, or it is not known.
  std::optional<Down> down;
  // What the agent adds: lengths in the local map are in a unit of its own, and in the global frame
  // in an unknown one, too.
  bool without_metres = false;
  bool global_without_metres = false;
  // Where the local map lies (AgentStatus::global_from_local), as it was when the pose was found in
  // it: what was corrected since is in neither.
  std::optional<Similarity3d> global_from_local;
  // What SmoothPose adds, whether there is a pose or not.
  uint64_t epoch = 0;
  // The covariance of what the map near the camera has drifted since the epoch began (PoseDrift),
  // in the map's axes; nullopt where nobody knows.
  std::optional<Matrix6d> drift;
  std::optional<Rigid3d> odom_from_camera;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_TRACKING_RESULT_H_
