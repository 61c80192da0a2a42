// Follows the camera without the jumps that corrections of the map make, and counts these.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_SMOOTH_POSE_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_SMOOTH_POSE_H_

#include <cstdint>
#include <optional>

#include "client_agent/agent/pose_drift.h"
#include "client_agent/tracking/tracking_result.h"
#include "slam/geometry/rigid3.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

// Adds up the motions of frames in a frame of its own, "odom": the frame of the first local map
// until something jumps. Not thread-safe.
class SmoothPose {
 public:
  // Sets epoch, drift and odom_from_camera of the next frame's result. The epoch is the number of
  // the jumps so far, from 1 on; odom_from_camera is nullopt before the first pose. Where the
  // camera is found again, a known motion since the last pose is added as one step; in another
  // local map nobody knows it, and the camera is taken not to have moved. Where an IMU says how a
  // camera moves that is lost, that is added until it is found.
  void Add(TrackingResult& result);

  // Notes that the camera goes on in another local map at the pose that it has, which is no jump.
  void GoOnIn(LocalMapId local_map) {
    local_map_ = local_map;
    corrections_ = 0;
  }

 private:
  // Returns whether the pose does not go on from the one before by what the camera moved.
  bool Jumps(const TrackingResult& result) const;

  uint64_t epoch_ = 0;
  std::optional<Rigid3d> odom_from_camera_;  // At the last frame that had a pose.
  std::optional<Rigid3d> told_;              // Of the last frame.
  PoseDrift drift_;
  bool had_pose_ = false;
  LocalMapId local_map_;
  uint64_t corrections_ = 0;
};

// Returns how well the map supports a pose, from 0 to 1: the less of m / (m + 100) for m points
// that agree with it, and of 1/0.3 of their share of the points in view. Tracking doubts a pose at
// a share of 0.15 (TrackerOptions), which is 0.5 here.
double PoseQuality(const TrackingResult& result);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_SMOOTH_POSE_H_
