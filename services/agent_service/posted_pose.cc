#include "services/agent_service/posted_pose.h"

#include "client_agent/agent/smooth_pose.h"
#include "services/convert/geometry.h"
#include "slam/geometry/lie.h"
#include "slam/optimisation/pose_covariance.h"

namespace corbslam::services {

using client_agent::TrackingResult;
using client_agent::TrackingState;
using client_agent::WhyNoPose;

namespace {

// Writes the covariance of the wanted frame, from the camera's; nothing for none.
void WriteCovariance(const Rigid3d& camera_from_local, const std::optional<Matrix6d>& of_camera,
                     const Rigid3d& camera_from_wanted,
                     google::protobuf::RepeatedField<double>& written) {
  if (!of_camera.has_value()) return;
  const Matrix6d covariance =
      OfAttachedFrame(camera_from_local.Inverse(), camera_from_wanted, *of_camera);
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) written.Add(covariance(row, column));
  }
}

void WriteVelocity(const PostedPose& posted, const Rigid3d& camera_from_wanted,
                   v1::WatchPoseResponse& response) {
  const auto& motion = posted.result.motion;
  if (!posted.follows_a_pose || !motion.has_value() || motion->since_ns == 0) return;
  const Rigid3d before_from_now =
      camera_from_wanted.Inverse() * motion->camera_from_previous.Inverse() * camera_from_wanted;
  const Vector6d moved = LogSE3(before_from_now) / (1e-9 * static_cast<double>(motion->since_ns));
  response.mutable_velocity()->Add(moved.begin(), moved.end());
}

void WriteDown(const Down& down, const Rigid3d& camera_from_wanted,
               v1::WatchPoseResponse& response) {
  const Eigen::Vector3d direction = camera_from_wanted.rotation.conjugate() * down.in_camera;
  v1::Down& written = *response.mutable_down();
  written.set_x(direction.x());
  written.set_y(direction.y());
  written.set_z(direction.z());
  written.set_sigma_rad(down.sigma_rad);
}

void WritePose(const PostedPose& posted, const Rigid3d& camera_from_wanted,
               v1::WatchPoseResponse& response) {
  const TrackingResult& result = posted.result;
  const Rigid3d local_from_camera = result.camera_from_local.Inverse();
  ToProto(local_from_camera * camera_from_wanted, response.mutable_local_from_camera());
  if (result.odom_from_camera.has_value()) {
    ToProto(local_from_camera * result.odom_from_camera->Inverse(),
            response.mutable_map_from_odom());
  }
  response.set_quality(client_agent::PoseQuality(result));
  response.set_points_matched(static_cast<uint32_t>(result.points_matched));
  response.set_points_in_view(static_cast<uint32_t>(result.points_in_view));
  WriteCovariance(result.camera_from_local, result.covariance, camera_from_wanted,
                  *response.mutable_covariance());
  WriteCovariance(result.camera_from_local, result.drift, camera_from_wanted,
                  *response.mutable_drift());
  WriteVelocity(posted, camera_from_wanted, response);
  if (result.down.has_value()) WriteDown(*result.down, camera_from_wanted, response);
}

void WriteReckoned(const client_agent::ReckonedPose& reckoned, const Rigid3d& camera_from_wanted,
                   v1::ReckonedPose& written) {
  ToProto(reckoned.camera_from_local.Inverse() * camera_from_wanted,
          written.mutable_local_from_camera());
  WriteCovariance(reckoned.camera_from_local, reckoned.covariance, camera_from_wanted,
                  *written.mutable_covariance());
  written.set_since_s(1e-9 * static_cast<double>(reckoned.motion.since_ns));
}

}  // namespace

v1::WatchPoseResponse ToProto(const PostedPose& posted, PosesOf poses_of,
                              const std::optional<Rigid3d>& camera_from_wanted) {
  const TrackingResult& result = posted.result;
  const Rigid3d wanted = camera_from_wanted.value_or(Rigid3d::Identity());
  v1::WatchPoseResponse response;
  response.set_timestamp_ns(result.timestamp_ns);
  response.set_state(ToProto(result.state));
  response.set_why_no_pose(ToProto(result.why_no_pose));
  response.set_local_map(ToString(result.local_map));
  response.set_poses_of(ToProto(poses_of));
  response.set_epoch(result.epoch);
  response.set_global_epoch(posted.global_epoch);
  response.set_without_metres(result.without_metres);
  if (result.state == TrackingState::kTracking) WritePose(posted, wanted, response);
  if (result.reckoned.has_value()) {
    WriteReckoned(*result.reckoned, wanted, *response.mutable_reckoned());
  }
  if (result.odom_from_camera.has_value()) {
    ToProto(*result.odom_from_camera * wanted, response.mutable_odom_from_camera());
  }
  if (result.global_from_local.has_value()) {
    ToProto(*result.global_from_local, response.mutable_global_from_local());
    response.set_global_without_metres(result.global_without_metres);
  }
  return response;
}

v1::TrackingState ToProto(TrackingState state) {
  switch (state) {
    case TrackingState::kNotInitialised:
      return v1::TRACKING_STATE_INITIALISING;
    case TrackingState::kTracking:
      return v1::TRACKING_STATE_TRACKING;
    case TrackingState::kLost:
      return v1::TRACKING_STATE_LOST;
  }
  return v1::TRACKING_STATE_UNSPECIFIED;
}

v1::WhyNoPose ToProto(WhyNoPose why) {
  switch (why) {
    case WhyNoPose::kHasOne:
      return v1::WHY_NO_POSE_UNSPECIFIED;
    case WhyNoPose::kFewKeypoints:
      return v1::WHY_NO_POSE_FEW_KEYPOINTS;
    case WhyNoPose::kFewDepths:
      return v1::WHY_NO_POSE_FEW_DEPTHS;
    case WhyNoPose::kLittleParallax:
      return v1::WHY_NO_POSE_LITTLE_PARALLAX;
    case WhyNoPose::kMappingBusy:
      return v1::WHY_NO_POSE_MAPPING_BUSY;
    case WhyNoPose::kMappingPaused:
      return v1::WHY_NO_POSE_MAPPING_PAUSED;
    case WhyNoPose::kNotRecognised:
    case WhyNoPose::kAnotherCamera:
      return v1::WHY_NO_POSE_NOT_RECOGNISED;
  }
  return v1::WHY_NO_POSE_UNSPECIFIED;
}

}  // namespace corbslam::services
