#include "client_agent/agent/pose_drift.h"

#include <Eigen/Cholesky>
#include <vector>

#include "slam/optimisation/pose_covariance.h"
#include "slam/util/median.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kFewestSteps = 5;
constexpr size_t kMostSteps = 30;
constexpr double kMedianChi2OfSix = 5.348;

Eigen::Vector3d PositionOf(const Rigid3d& camera_from_map) {
  return camera_from_map.Inverse().translation;
}

// A rigid movement of the map, by what it does at another place, `by` metres away.
Matrix6d CarryBy(const Eigen::Vector3d& by, const Matrix6d& covariance) {
  return OfAttachedFrame(Rigid3d::Identity(), {Eigen::Quaterniond::Identity(), by}, covariance);
}

Vector6d CarryBy(const Eigen::Vector3d& by, const Vector6d& movement) {
  Vector6d carried = movement;
  carried.head<3>() += movement.tail<3>().cross(by);
  return carried;
}

// Returns what moved a camera's pose from one to the other, along and about the map's axes.
Vector6d MovementOf(const Rigid3d& before_from_map, const Rigid3d& after_from_map) {
  Vector6d movement;
  movement.head<3>() = PositionOf(after_from_map) - PositionOf(before_from_map);
  movement.tail<3>() = LogSO3(after_from_map.rotation.conjugate() * before_from_map.rotation);
  return movement;
}

}  // namespace

void PoseDrift::Begin(const TrackingResult& result) {
  drift_ = Matrix6d::Zero();
  before_ = result;
  tracked_.setZero();
  moved_.setZero();
  expected_.reset();
}

double PoseDrift::rate() const {
  if (steps_.size() < kFewestSteps) return 1;
  return MeanMedian({steps_.begin(), steps_.end()}) / kMedianChi2OfSix;
}

void PoseDrift::GoOn(const TrackingResult& result) {
  // The first frame of a map has no points to be sure by; the one after it says as much.
  const std::optional<Matrix6d>& covariance =
      before_.covariance.has_value() ? before_.covariance : result.covariance;
  if (!drift_.has_value() || !result.motion.has_value() || !covariance.has_value()) {
    drift_.reset();
    return;
  }
  tracked_ += *covariance;
  if (before_.made_keyframe || result.follows_keyframe) Learn();
  const Rigid3d before_as_it_is =
      result.motion->camera_from_previous.Inverse() * result.camera_from_local;
  const Vector6d step = MovementOf(before_.camera_from_local, before_as_it_is);
  moved_ += step;

  const Eigen::Vector3d by =
      PositionOf(result.camera_from_local) - PositionOf(before_.camera_from_local);
  drift_ = CarryBy(by, Matrix6d(*drift_ + rate() * *covariance + step * step.transpose()));
  tracked_ = CarryBy(by, tracked_);
  moved_ = CarryBy(by, moved_);
  if (expected_.has_value()) expected_ = CarryBy(by, *expected_);
  before_ = result;
}

// At a keyframe: what adjustment did since the one before tells how wrong that was. Where it has
// not come to adjust, nothing does.
void PoseDrift::Learn() {
  if (expected_.has_value() && moved_.squaredNorm() > 1e-20) {
    const double square = moved_.dot(expected_->ldlt().solve(moved_));
    if (square >= 0) steps_.push_back(square);
    if (steps_.size() > kMostSteps) steps_.pop_front();
  }
  expected_ = tracked_;
  tracked_.setZero();
  moved_.setZero();
}

Matrix6d DriftBetween(const TrackingResult& from, const TrackingResult& to) {
  const Eigen::Vector3d by = PositionOf(to.camera_from_local) - PositionOf(from.camera_from_local);
  return *to.drift - CarryBy(by, *from.drift);
}

}  // namespace corbslam::client_agent
