#include "services/ros2/ros2_poses.h"

#include "slam/geometry/same_motion.h"
#include "slam/optimisation/pose_covariance.h"

namespace corbslam::services {

using client_agent::TrackingResult;
using client_agent::TrackingState;

namespace {

// Returns the covariance about other axes, turned and scaled by the similarity.
Matrix6d InAxes(const Similarity3d& target_from_source, const Matrix6d& covariance) {
  Matrix6d turn = Matrix6d::Zero();
  const Eigen::Matrix3d rotation = target_from_source.rotation.toRotationMatrix();
  turn.topLeftCorner<3, 3>() = target_from_source.scale * rotation;
  turn.bottomRightCorner<3, 3>() = rotation;
  return turn * covariance * turn.transpose();
}

std::optional<Vector6d> VelocityOf(const TrackingResult& result, const Rigid3d& camera_from_base) {
  const bool is_reckoned = result.reckoned.has_value();
  // A reckoned motion is since the last pose, not since the last frame.
  if (is_reckoned || !result.motion.has_value() || result.motion->since_ns <= 0) {
    return std::nullopt;
  }
  const Rigid3d before_from_now =
      camera_from_base.Inverse() * result.motion->camera_from_previous.Inverse() * camera_from_base;
  return LogSE3(before_from_now) / (1e-9 * static_cast<double>(result.motion->since_ns));
}

void AddMap(const TrackingResult& result, const Ros2Mounting& mounting, Ros2Poses& poses) {
  const Rigid3d local_from_camera = result.camera_from_local.Inverse();
  poses.local_from_base = local_from_camera * mounting.camera_from_base;
  if (!result.global_from_local.has_value() && mounting.has_store) return;
  poses.map_from_local = Similarity3d::FromRigid(mounting.map_from_global) *
                         result.global_from_local.value_or(Similarity3d::Identity());
  // Base is fixed to the camera, whatever the map's scale.
  poses.map_from_base = Moved(*poses.map_from_local, local_from_camera) * mounting.camera_from_base;
  if (!result.covariance.has_value()) return;
  poses.map_covariance =
      InAxes(*poses.map_from_local,
             OfAttachedFrame(local_from_camera, mounting.camera_from_base, *result.covariance));
}

void AddOdom(const TrackingResult& result, const Ros2Mounting& mounting, Ros2Poses& poses) {
  poses.odom_from_base =
      mounting.odom_from_tracked * *result.odom_from_camera * mounting.camera_from_base;
  poses.is_reckoned = result.state != TrackingState::kTracking;
  poses.velocity = VelocityOf(result, mounting.camera_from_base);
  if (poses.is_reckoned || !result.covariance.has_value() || !result.drift.has_value()) return;
  const Rigid3d local_from_camera = result.camera_from_local.Inverse();
  const Rigid3d odom_from_local =
      mounting.odom_from_tracked * *result.odom_from_camera * result.camera_from_local;
  poses.odom_covariance = InAxes(Similarity3d::FromRigid(odom_from_local),
                                 OfAttachedFrame(local_from_camera, mounting.camera_from_base,
                                                 *result.covariance + *result.drift));
}

}  // namespace

Rigid3d Moved(const Similarity3d& target_from_source, const Rigid3d& source_from_base) {
  return {(target_from_source.rotation * source_from_base.rotation).normalized(),
          target_from_source * source_from_base.translation};
}

Ros2Mounting MakeMounting(const RecordedCamera& recorded, const Rigid3d& map_from_global,
                          bool has_store) {
  Ros2Mounting mounting;
  const Rigid3d base_from_recorded = recorded.body_from_recorded.value_or(Rigid3d::Identity());
  mounting.camera_from_base = recorded.camera_from_recorded * base_from_recorded.Inverse();
  const bool is_camera =
      AreSame(Similarity3d::FromRigid(base_from_recorded), Similarity3d::Identity());
  // x right, y down, z ahead become x ahead, y left, z up.
  const Rigid3d level = {Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), Eigen::Vector3d::Zero()};
  mounting.odom_from_tracked =
      is_camera ? level * mounting.camera_from_base.Inverse() : mounting.camera_from_base.Inverse();
  mounting.map_from_global = map_from_global;
  mounting.has_store = has_store;
  return mounting;
}

std::optional<Rigid3d> Ros2Poses::MapFromOdom() const {
  if (!map_from_base.has_value() || !odom_from_base.has_value()) return std::nullopt;
  return *map_from_base * odom_from_base->Inverse();
}

Ros2Poses MakePoses(const TrackingResult& result, const Ros2Mounting& mounting) {
  Ros2Poses poses;
  poses.timestamp_ns = result.timestamp_ns;
  poses.local_map = result.local_map;
  const bool is_tracking = result.state == TrackingState::kTracking;
  if (is_tracking) AddMap(result, mounting, poses);
  // While nobody knows how the camera moves odom stays as it was, which is not told.
  if ((is_tracking || result.reckoned.has_value()) && result.odom_from_camera.has_value()) {
    AddOdom(result, mounting, poses);
  }
  return poses;
}

}  // namespace corbslam::services
