// Decides whether a frame is worth keeping.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_KEYFRAME_POLICY_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_KEYFRAME_POLICY_H_

#include "client_agent/tracking/frame.h"

namespace corbslam::client_agent {

struct KeyframePolicyOptions {
  // Largest share of the reference keyframe's points that may be tracked for a new keyframe.
  double max_tracked_ratio = 0.75;
  // The same once the last keyframe is later_s old: what little is new may be what a turning camera
  // comes back to (docs/adr/0012-provisional-keyframes.md).
  double max_tracked_ratio_later = 0.9;
  double later_s = 0.4;
  // The same while the map has one keyframe.
  double max_tracked_ratio_at_start = 0.4;
  // With a smaller share, a new keyframe does not wait for a busy mapper.
  double urgent_tracked_ratio = 0.25;
  // It is time to make close points when fewer are tracked and many could be made.
  int min_close_tracked = 100;
  int min_close_untracked = 70;
  // Share of the points a frame sees that its reference must see, too, where another robot's map
  // keeps the frame tracked. The own map is to hold together by itself.
  double min_share_of_reference = 0.5;
  // A new keyframe must still be tracked with so many inliers.
  int min_inliers = 15;
  double max_interval_s = 1.0;
};

// Returns the options of one camera alone: what it sees for the first time has no depth until it is
// seen from elsewhere, so that keyframes come sooner, from the first on (ORB-SLAM, T-RO 2015, V.E).
KeyframePolicyOptions OfOneCamera();

// The evidence that the decision rests on.
struct KeyframeEvidence {
  int inliers = 0;
  // Points of the reference keyframe that enough keyframes see.
  int reference_points = 0;
  // Share of the points seen by the frame that the reference sees, too.
  double share_of_reference = 1;
  int map_keyframes = 0;
  int close_tracked = 0;
  int close_untracked = 0;
  double since_last_keyframe_s = 0;
  bool mapper_idle = true;
  bool queue_has_room = true;
};

// Counts the frame's close keypoints that do and don't see a map point.
void CountClosePoints(const Frame& frame, KeyframeEvidence& evidence);

// Applies the rule of ORB-SLAM2 for sensors with depth (T-RO 2017, III.E), with
// max_tracked_ratio_later and min_share_of_reference. Pure.
bool ShouldMakeKeyframe(const KeyframeEvidence& evidence,
                        const KeyframePolicyOptions& options = {});

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_KEYFRAME_POLICY_H_
