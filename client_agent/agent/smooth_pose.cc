#include "client_agent/agent/smooth_pose.h"

#include <algorithm>

namespace corbslam::client_agent {
namespace {

constexpr double kHalfPoints = 100;
constexpr double kFullShare = 0.3;

}  // namespace

void SmoothPose::Add(TrackingResult& result) {
  const bool has_pose = result.state == TrackingState::kTracking;
  if (has_pose) {
    if (Jumps(result)) {
      ++epoch_;
      drift_.Begin(result);
    } else {
      drift_.GoOn(result);
    }
    result.drift = drift_.drift();
    if (!odom_from_camera_.has_value()) {
      odom_from_camera_ = result.camera_from_local.Inverse();
    } else if (result.motion.has_value() && result.local_map == local_map_) {
      odom_from_camera_ = *odom_from_camera_ * result.motion->camera_from_previous.Inverse();
    }
    local_map_ = result.local_map;
    corrections_ = result.corrections;
  }
  had_pose_ = has_pose;
  result.epoch = epoch_;
  if (has_pose) told_ = odom_from_camera_;
  if (odom_from_camera_.has_value() && result.reckoned.has_value()) {
    told_ = *odom_from_camera_ * result.reckoned->motion.camera_from_previous.Inverse();
  }
  result.odom_from_camera = told_;
}

bool SmoothPose::Jumps(const TrackingResult& result) const {
  return !had_pose_ || result.local_map != local_map_ || result.corrections != corrections_;
}

double PoseQuality(const TrackingResult& result) {
  if (result.state != TrackingState::kTracking || result.points_matched == 0) return 0;
  const double matched = result.points_matched;
  const double in_view = std::max(result.points_in_view, result.points_matched);
  return std::min({matched / (matched + kHalfPoints), matched / in_view / kFullShare, 1.0});
}

}  // namespace corbslam::client_agent
