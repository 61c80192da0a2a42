// Implements the part of SingleAgent that goes by an IMU, too.
#include <glog/logging.h>

#include "absl/strings/string_view.h"
#include "client_agent/agent/single_agent.h"
#include "slam/optimisation/pose_covariance.h"

namespace corbslam::client_agent {
namespace {

// What a pose is taken to be off by whose points don't say it, and what those may be off by beside
// what they say that a camera has just after it was found.
constexpr double kUnknown_m = 0.03;
constexpr double kUnknown_rad = 0.02;
constexpr int kJustFound = 3;

absl::string_view CodeOf(InertialDoubt::Kind kind) {
  switch (kind) {
    case InertialDoubt::Kind::kMissing:
      return "imu-missing";
    case InertialDoubt::Kind::kGap:
      return "imu-gap";
    case InertialDoubt::Kind::kLate:
      return "imu-late";
    case InertialDoubt::Kind::kContradicts:
      return "imu-contradicts";
  }
  return "imu-contradicts";
}

Matrix6d Unknown() {
  Matrix6d unknown = Matrix6d::Identity() * (kUnknown_m * kUnknown_m);
  unknown.bottomRightCorner<3, 3>() = Eigen::Matrix3d::Identity() * (kUnknown_rad * kUnknown_rad);
  return unknown;
}

}  // namespace

void SingleAgent::ExpectByImu(const SensorImages& images) {
  if (!inertial_.has_value()) return;
  inertial_->Add(images.imu);
  current().tracker().Expect(inertial_->Since(images.timestamp_ns));
}

void SingleAgent::LearnByImu(TrackingResult& result) {
  if (!inertial_.has_value()) return;
  if (result.state == TrackingState::kTracking) {
    const bool is_vague = !result.covariance.has_value() || tracked_in_a_row_ < kJustFound;
    Matrix6d covariance = is_vague ? Unknown() : Matrix6d::Zero();
    if (result.covariance.has_value()) {
      // Back from the map's axes.
      covariance += InMapAxes(result.camera_from_local.Inverse(), *result.covariance);
    }
    // What the IMU itself said is no news to it; nor is what the map says of a gap, which it may
    // not show the other end of well.
    const bool goes_on = tracked_in_a_row_ > 0 && !result.was_bridged &&
                         result.motion.has_value() &&
                         inertial_->last_ns() == result.timestamp_ns - result.motion->since_ns;
    ++tracked_in_a_row_;
    inertial_->Track(result.timestamp_ns,
                     goes_on ? std::optional(result.motion->camera_from_previous) : std::nullopt,
                     covariance);
    result.down = inertial_->state().down;
  } else {
    tracked_in_a_row_ = 0;
  }
  for (const InertialDoubt& doubt : inertial_->TakeDoubts()) {
    SayFinding({FindingLevel::kWarning, std::string(CodeOf(doubt.kind)), doubt.text});
  }
  const InertialState state = inertial_->state();
  if (result.was_bridged) {
    LOG(INFO) << options_.name << ": no picture said how the camera came here in "
              << 1e-9 * static_cast<double>(result.motion->since_ns)
              << " s; the map goes on where the IMU takes it";
  }
  absl::MutexLock lock(&mutex_);
  if (state.is_ready && !(status_.inertial.has_value() && status_.inertial->is_ready)) {
    LOG(INFO) << options_.name << ": the IMU is known well enough to be gone by";
  }
  status_.inertial = state;
  status_.bridged += result.was_bridged ? 1 : 0;
}

}  // namespace corbslam::client_agent
