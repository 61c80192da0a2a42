// When is a frame worth keeping?
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_KEYFRAME_POLICY_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_KEYFRAME_POLICY_H_

#include "client_agent/tracking/frame.h"

namespace corbslam {

struct KeyframePolicyOptions {
  // Of the reference keyframe's points, how many may be tracked at most for a new keyframe.
  double max_tracked_ratio = 0.75;
  // And once the last keyframe is this old: what little is new may be what a turning camera comes
  // back to. docs/adr/0012-provisional-keyframes.md
  double max_tracked_ratio_later = 0.9;
  double later_s = 0.4;
  // While the map has one keyframe.
  double max_tracked_ratio_at_start = 0.4;
  // Below it the mapper's being busy is no reason to wait.
  double urgent_tracked_ratio = 0.25;
  // Few close points tracked although many could be made: time to make them.
  int min_close_tracked = 100;
  int min_close_untracked = 70;
  // Where another robot's map keeps a frame tracked: of the points that it sees, how many its
  // reference must see, too. The own map is to hold together by itself.
  double min_share_of_reference = 0.5;
  // The frame must still be well tracked.
  int min_inliers = 15;
  double max_interval_s = 1.0;
};

// What the decision rests on.
struct KeyframeEvidence {
  int inliers = 0;
  // Points of the reference keyframe that enough keyframes see.
  int reference_points = 0;
  // Of the points that the frame sees, the share that the reference sees.
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

// The rule of ORB-SLAM2 for sensors with depth (T-RO 2017, III.E), with max_tracked_ratio_later and
// min_share_of_reference.
// Pure.
bool ShouldMakeKeyframe(const KeyframeEvidence& evidence,
                        const KeyframePolicyOptions& options = {});

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_KEYFRAME_POLICY_H_
