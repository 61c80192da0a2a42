// Says how far the map around the camera may have drifted while the camera drove on.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_POSE_DRIFT_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_POSE_DRIFT_H_

#include <deque>
#include <optional>

#include "client_agent/tracking/tracking_result.h"
#include "slam/geometry/lie.h"

namespace corbslam::client_agent {

// Adds up, over the frames of an epoch, the covariance of what a pose's own covariance doesn't have
// in: the errors of the map near the camera, which frames share and which change as the map goes on
// beneath them. Two parts, for each frame:
//  - a random walk: `rate` times the covariance of the frame before. The rate is estimated from
//    what local adjustment does to the poses of new keyframes (Mehra, "On the identification of
//    variances and adaptive Kalman filtering", 1970): the median of the squares of these steps in
//    units of the covariances of the frames since the keyframe before, over that of chi2. With too
//    few of them it is 1: each frame as wrong as one that is tracked from the one before.
//  - the step itself by which the map was moved under the frame before, which its pose, given away
//    already, lacks.
// Not thread-safe.
class PoseDrift {
 public:
  // Begins anew at the frame's pose: nothing has drifted. The rate stays.
  void Begin(const TrackingResult& result);

  // Goes on to the next frame that has a pose in the same epoch, with its motion.
  void GoOn(const TrackingResult& result);

  // The covariance of how the map near the camera has moved since Begin, as a rigid body: position
  // at the camera and rotation, along and about the map's axes. Nullopt before Begin, and to the
  // end of the epoch after a frame from which nothing followed (no motion or covariances).
  const std::optional<Matrix6d>& drift() const { return drift_; }
  double rate() const;

 private:
  void Learn();

  std::optional<Matrix6d> drift_;
  TrackingResult before_;
  // Since the last keyframe, at the camera: the frames' covariances, and how the map was moved.
  Matrix6d tracked_ = Matrix6d::Zero();
  Vector6d moved_ = Vector6d::Zero();
  // The covariances of the frames of the interval that the last keyframe ended.
  std::optional<Matrix6d> expected_;
  // The newest keyframes' steps, normalised and squared.
  std::deque<double> steps_;
};

// Returns the drift between two frames of one epoch, at the later one's camera, from theirs.
Matrix6d DriftBetween(const TrackingResult& from, const TrackingResult& to);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_POSE_DRIFT_H_
