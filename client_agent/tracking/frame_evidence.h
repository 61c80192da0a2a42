// Judges a frame that was found in others' map as a look-up of a picture is judged.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_FRAME_EVIDENCE_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_FRAME_EVIDENCE_H_

#include <optional>
#include <vector>

#include "client_agent/tracking/frame.h"
#include "client_agent/tracking/local_map_view.h"
#include "slam/verification/camera_check.h"

namespace corbslam::client_agent {

// What speaks for the pose of a frame: the points that it is associated with, of those that it may
// see. The frame must outlive it.
class FrameEvidence {
 public:
  FrameEvidence(const Frame& frame, const std::vector<PointInView>& points);

  // Returns what corbslam::CheckCamera does, given every point and the keypoint that looks most
  // like it.
  CameraCheck CheckCamera() const;
  // Returns how many points must agree with the pose (corbslam::CountInliersNeeded).
  int InliersNeeded() const;

 private:
  std::vector<const MapPoint*> Pointers() const;
  std::vector<PoseObservation> LooksAlike() const;

  const Frame& frame_;
  Keyframe as_keyframe_;
  std::vector<MapPoint> points_;
};

// Returns the covariance of the frame's pose in the map's axes whatever camera took it, and not
// only for the frame's own (CovarianceOfAnyCamera); nullopt where the associations don't determine
// it.
std::optional<Matrix6d> AnyCamerasCovariance(const Frame& frame);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_FRAME_EVIDENCE_H_
