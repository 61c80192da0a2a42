// Implements the part of Tracker that goes by what an IMU says.
#include <Eigen/Cholesky>
#include <cmath>

#include "client_agent/tracking/tracker.h"
#include "slam/geometry/lie.h"
#include "slam/optimisation/pose_covariance.h"

namespace corbslam::client_agent {
namespace {

// A map goes on where the IMU takes the camera to be: known so well, and not before the map has
// failed to show so many frames in a row.
constexpr double kWellKnown_m = 0.1;
constexpr double kWellKnown_rad = 0.03;
constexpr int kLeastUnrecognised = 8;
// What is so many standard deviations away, and this far, can't have been reached. A gyroscope
// knows turns over seconds better than a picture that shows little.
constexpr double kOutOfReach = 8;
constexpr double kOutOfReach_m = 0.3;
constexpr double kOutOfReach_rad = 0.01;
constexpr int kFewPoints = 150;

double Position_m(const Matrix6d& covariance) {
  return std::sqrt(covariance.topLeftCorner<3, 3>().trace() / 3);
}

double Rotation_rad(const Matrix6d& covariance) {
  return std::sqrt(covariance.bottomRightCorner<3, 3>().trace() / 3);
}

}  // namespace

void Tracker::CheckExpected(int64_t timestamp_ns) {
  if (!expected_.has_value()) return;
  const bool goes_on = previous_.has_value() &&
                       timestamp_ns - previous_->payload->timestamp_ns == expected_->since_ns;
  if (!goes_on) expected_.reset();
}

Rigid3d Tracker::ExpectedPose() const {
  return expected_->camera_from_previous * previous_->camera_from_map;
}

bool Tracker::FollowExpected(Frame& frame) const {
  if (!expected_.has_value()) return false;
  return TrackPreviousFrame(ExpectedPose(), options_.previous_frame_radius_px, frame);
}

bool Tracker::ComeBackAsExpected(Frame& frame) const {
  if (!expected_.has_value()) return false;
  return RelocaliseNear(*parts_.map, ExpectedPose(), frame);
}

bool Tracker::IsWithinReach(const Solution& solution) const {
  if (state_ != TrackingState::kLost || !expected_.has_value()) return true;
  const Rigid3d expected = ExpectedPose();
  const double off_m =
      (CameraCentre(expected) - CameraCentre(solution.frame.camera_from_map)).norm();
  if (off_m > kOutOfReach_m + kOutOfReach * Position_m(expected_->covariance)) return false;
  const double off_rad =
      RotationAngle(expected.rotation * solution.frame.camera_from_map.rotation.conjugate());
  if (off_rad > kOutOfReach_rad + kOutOfReach * Rotation_rad(expected_->covariance)) return false;
  // Some dozens of points agree with a pose that is a little wrong.
  if (solution.inliers.map_points >= kFewPoints) return true;
  const std::optional<Apart> apart = FromExpected(solution.frame);
  return !apart.has_value() || apart->distance <= kUsualDistance;
}

std::optional<Tracker::Apart> Tracker::FromExpected(const Frame& frame) const {
  const std::optional<ReckonedPose> reckoned = Reckon();
  const std::optional<Matrix6d> found_covariance = FramePoseCovariance(frame);
  if (!reckoned.has_value() || !found_covariance.has_value()) return std::nullopt;
  const Rigid3d found = frame.camera_from_map.Inverse();
  const Rigid3d expected = reckoned->camera_from_local.Inverse();
  Vector6d off;
  off << found.translation - expected.translation,
      LogSO3(found.rotation * expected.rotation.conjugate());
  const Matrix6d both = reckoned->covariance + *found_covariance;
  const Vector6d weighed = both.ldlt().solve(off);
  return Apart{off.dot(weighed), reckoned->covariance * weighed, expected};
}

std::optional<ReckonedPose> Tracker::Reckon() const {
  if (!expected_.has_value()) return std::nullopt;
  ReckonedPose reckoned;
  reckoned.motion = {expected_->camera_from_previous, expected_->since_ns};
  reckoned.camera_from_local = ExpectedPose();
  const Rigid3d map_from_previous = previous_->camera_from_map.Inverse();
  reckoned.covariance = InMapAxes(previous_->camera_from_map, expected_->covariance);
  if (previous_covariance_.has_value()) {
    reckoned.covariance += OfAttachedFrame(
        map_from_previous, expected_->camera_from_previous.Inverse(), *previous_covariance_);
  }
  return reckoned;
}

void Tracker::WeighExpected(Frame& frame) const {
  const std::optional<Apart> apart = FromExpected(frame);
  // Where they contradict, what many points say holds.
  if (!apart.has_value() || apart->distance > kUsualDistance) return;
  const Rigid3d map_from_camera = {
      (ExpSO3(apart->step.tail<3>()) * apart->map_from_expected.rotation).normalized(),
      apart->map_from_expected.translation + apart->step.head<3>()};
  frame.camera_from_map = map_from_camera.Inverse();
}

bool Tracker::IsWellReckoned() const {
  return expected_.has_value() && Position_m(expected_->covariance) < kWellKnown_m &&
         Rotation_rad(expected_->covariance) < kWellKnown_rad;
}

bool Tracker::MayBridge() const {
  if (mapping_paused_ || options_.localise_only || begins_lost_) return false;
  return IsWellReckoned() && previous_->reference.IsValid() &&
         unrecognised_in_a_row_ >= kLeastUnrecognised && parts_.queue->HasRoom();
}

bool Tracker::Bridge(Frame& frame) {
  if (!MayBridge()) return false;
  parts_.map->ReadWithHistory(
      [&](const Map& map, const MapHistory& history) { Refresh(map, history, *previous_); });
  frame.associations.assign(frame.keypoints().size(), Association());
  frame.camera_from_map = ExpectedPose();
  frame.reference = previous_->reference;
  frame.camera_from_reference = expected_->camera_from_previous * previous_->camera_from_reference;
  MakeKeyframe(frame);
  if (!frame.keyframe.IsValid()) return false;
  bridge_ = frame.keyframe;
  corrections_ = parts_.map->corrections();
  inliers_ = {};
  points_in_view_ = 0;
  frames_since_relocalisation_ = 0;
  velocity_.reset();
  return true;
}

}  // namespace corbslam::client_agent
