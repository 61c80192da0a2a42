#include "client_agent/tracking/keyframe_policy.h"

namespace corbslam::client_agent {

KeyframePolicyOptions OfOneCamera() {
  KeyframePolicyOptions options;
  options.max_tracked_ratio = 0.9;
  options.max_tracked_ratio_at_start = 0.9;
  return options;
}

void CountClosePoints(const Frame& frame, KeyframeEvidence& evidence) {
  if (!frame.camera().IsMetric()) return;
  const double least_px = DisparityFromDepth(frame.camera(), frame.camera().close_depth_m);
  for (size_t i = 0; i < frame.associations.size(); ++i) {
    if (frame.keypoints()[i].disparity_px <= least_px) continue;
    const bool tracked = frame.associations[i].kind == Association::Kind::kMapPoint;
    ++(tracked ? evidence.close_tracked : evidence.close_untracked);
  }
}

bool ShouldMakeKeyframe(const KeyframeEvidence& evidence, const KeyframePolicyOptions& options) {
  if (!evidence.queue_has_room || evidence.inliers <= options.min_inliers) return false;
  const bool lacks_close = evidence.close_tracked < options.min_close_tracked &&
                           evidence.close_untracked > options.min_close_untracked;
  const double ratio_now = evidence.since_last_keyframe_s >= options.later_s
                               ? options.max_tracked_ratio_later
                               : options.max_tracked_ratio;
  const double max_ratio =
      evidence.map_keyframes < 2 ? options.max_tracked_ratio_at_start : ratio_now;
  const bool sees_new = evidence.inliers < max_ratio * evidence.reference_points;
  const bool leaves_reference = evidence.share_of_reference < options.min_share_of_reference;
  if (!sees_new && !lacks_close && !leaves_reference) return false;
  const bool urgent =
      lacks_close || evidence.inliers < options.urgent_tracked_ratio * evidence.reference_points;
  return evidence.mapper_idle || urgent || evidence.since_last_keyframe_s >= options.max_interval_s;
}

}  // namespace corbslam::client_agent
