#include "slam/inertial/inertial_odometry.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_format.h"

namespace corbslam {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Neighbouring frames' poses err alike, by no less than this.
constexpr double kLeastPosition_m = 0.002;
constexpr double kLeastTurn_rad = 0.001;
// How many times as long it takes until the IMU is believed after each time that
// the pictures contradicted it.
constexpr double kMoreTime = 4;
constexpr double kWellKnown_mps = 0.15;
constexpr double kWellKnown_rps = 0.01;
constexpr double kWellKnownDown_rad = 0.05;
// Neighbouring poses share what they are off by, scale among it, so that speed is off by a share.
constexpr double kSpeedOff = 0.02;
// Of the newest poses, how many may be further off than chance has it.
constexpr size_t kNewest = 40;
constexpr double kMostFar = 0.5;
constexpr size_t kLeastJudged = 20;
constexpr double kMostFarWhenReady = 0.2;
constexpr int64_t kSameOffset_ns = 3'000'000;
constexpr int64_t kJumpBack_ns = 1'000'000'000;
// Standing still: for so long no sample is further from the mean.
constexpr int64_t kStill_ns = 400'000'000;
constexpr double kStill_rps = 0.03;
constexpr double kStill_mps2 = 0.3;

double Sigma(const InertialFilter& filter, int block) {
  return std::sqrt(filter.covariance().block<3, 3>(block, block).trace() / 3);
}

// Of a direction: what lies along it is its length.
double DownSigma_rad(const InertialFilter& filter) {
  const Vector3d down = filter.gravity_mps2().normalized();
  const Matrix3d spread =
      filter.covariance().block<3, 3>(InertialFilter::kGravity, InertialFilter::kGravity);
  const double across = std::max(0.0, spread.trace() - down.dot(spread * down));
  return std::sqrt(across / 2) / filter.gravity_mps2().norm();
}

ImuSamples Shifted(ImuSamples samples, int64_t offset_ns) {
  for (ImuSample& sample : samples) sample.timestamp_ns += offset_ns;
  return samples;
}

Vector3d MeanForce(const std::vector<ImuStep>& steps) {
  Vector3d sum = Vector3d::Zero();
  for (const ImuStep& step : steps) sum += step.mean.specific_force_mps2;
  return sum / static_cast<double>(steps.size());
}

}  // namespace

InertialOdometry::InertialOdometry(const ImuCalibration& calibration,
                                   const Rigid3d& camera_from_recorded)
    : calibration_(calibration),
      imu_from_camera_(calibration.imu_from_camera * camera_from_recorded.Inverse()) {}

void InertialOdometry::Add(const ImuSamples& samples) {
  if (samples.empty()) return;
  if (samples.back().timestamp_ns + offset_ns_ < buffer_.newest_ns() - kJumpBack_ns) ForgetDrive();
  clock_.Add(samples);
  buffer_.Add(Shifted(samples, offset_ns_));
}

void InertialOdometry::ForgetDrive() {
  buffer_ = ImuBuffer();
  clock_ = ImuClock();
  axes_ = ImuAxes();
  turns_ = 0;
  next_clock_check_ = kLeastTurns;
  filter_.reset();
  last_.reset();
  taken_.reset();
  pending_.clear();
}

void InertialOdometry::Track(int64_t timestamp_ns,
                             const std::optional<Rigid3d>& camera_from_previous,
                             const Matrix6d& covariance) {
  Seen seen{timestamp_ns, {}};
  Rigid3d& odom_from_imu = seen.pose.odom_from_imu;
  if (camera_from_previous.has_value() && last_.has_value()) {
    odom_from_imu = last_->pose.odom_from_imu * imu_from_camera_ * camera_from_previous->Inverse() *
                    imu_from_camera_.Inverse();
  } else {
    odom_from_imu = Anchor(timestamp_ns);
  }
  const Matrix3d imu_turn = imu_from_camera_.rotation.toRotationMatrix();
  const Matrix3d odom_turn = odom_from_imu.rotation.toRotationMatrix() * imu_turn;
  seen.pose.covariance.setZero();
  seen.pose.covariance.topLeftCorner<3, 3>() =
      odom_turn * covariance.topLeftCorner<3, 3>() * odom_turn.transpose() +
      kLeastPosition_m * kLeastPosition_m * Matrix3d::Identity();
  seen.pose.covariance.bottomRightCorner<3, 3>() =
      imu_turn * covariance.bottomRightCorner<3, 3>() * imu_turn.transpose() +
      kLeastTurn_rad * kLeastTurn_rad * Matrix3d::Identity();
  last_ = seen;
  pending_.push_back(seen);
  TakePending();
}

Rigid3d InertialOdometry::Anchor(int64_t timestamp_ns) {
  pending_.clear();
  taken_.reset();
  if (!filter_.has_value()) return {};
  const bool goes_on = timestamp_ns - filter_ns_ <= kLongest_ns;
  if (!goes_on || GoOn(filter_ns_, timestamp_ns, *filter_).empty()) {
    filter_.reset();
    return {};
  }
  filter_ns_ = timestamp_ns;
  filter_->Anchor();
  return filter_->odom_from_imu();
}

void InertialOdometry::Begin(const Seen& seen) {
  constexpr int64_t kAbout_ns = 100'000'000;
  std::vector<ImuStep> about = buffer_.Between(seen.timestamp_ns - kAbout_ns, seen.timestamp_ns);
  if (about.empty()) about = buffer_.Between(seen.timestamp_ns - 1, seen.timestamp_ns);
  taken_.reset();
  filter_.reset();
  if (about.empty()) return;
  filter_.emplace(calibration_.noise, seen.pose, MeanForce(about));
  filter_ns_ = began_ns_ = seen.timestamp_ns;
  taken_ = seen;
  was_far_.clear();
}

void InertialOdometry::TakePending() {
  while (!pending_.empty() && buffer_.newest_ns() >= pending_.front().timestamp_ns) {
    const Seen seen = pending_.front();
    pending_.pop_front();
    Take(seen);
  }
  constexpr int64_t kLongestWait_ns = 1'000'000'000;
  if (pending_.empty()) return;
  const Seen newest = pending_.back();
  if (newest.timestamp_ns - pending_.front().timestamp_ns <= kLongestWait_ns) return;
  Doubt(InertialDoubt::Kind::kMissing,
        absl::StrFormat("no sample of the IMU came in the %.1f s before %d ns",
                        1e-9 * kLongestWait_ns, newest.timestamp_ns));
  pending_ = {newest};
  filter_.reset();
}

void InertialOdometry::Take(const Seen& seen) {
  if (!filter_.has_value()) {
    Begin(seen);
    return;
  }
  if (seen.timestamp_ns != filter_ns_) {
    const std::vector<ImuStep> steps = GoOn(filter_ns_, seen.timestamp_ns, *filter_);
    if (steps.empty()) {
      if (seen.timestamp_ns > filter_ns_) {
        Doubt(InertialDoubt::Kind::kGap,
              absl::StrFormat("samples of the IMU are missing in the %.3f s before %d ns",
                              1e-9 * static_cast<double>(seen.timestamp_ns - filter_ns_),
                              seen.timestamp_ns));
      }
      Begin(seen);
      return;
    }
    if (taken_.has_value()) CompareTurns(*taken_, seen, steps);
    buffer_.Forget(filter_ns_ - kStill_ns);
    filter_ns_ = seen.timestamp_ns;
    if (turns_ >= next_clock_check_) {
      next_clock_check_ *= 2;
      if (CorrectClock()) {
        Begin(seen);
        return;
      }
    }
  }
  taken_ = seen;
  Judge(seen, filter_->Update(seen.pose));
}

std::vector<ImuStep> InertialOdometry::GoOn(int64_t from_ns, int64_t to_ns,
                                            InertialFilter& filter) const {
  std::vector<ImuStep> steps = buffer_.Between(from_ns, to_ns);
  for (const ImuStep& step : steps) filter.Propagate(step.mean, step.duration_s);
  return steps;
}

void InertialOdometry::CompareTurns(const Seen& before, const Seen& seen,
                                    const std::vector<ImuStep>& steps) {
  const Rigid3d moved = before.pose.odom_from_imu.Inverse() * seen.pose.odom_from_imu;
  Vector3d felt_rad = Vector3d::Zero();
  double duration_s = 0;
  for (const ImuStep& step : steps) {
    felt_rad += step.duration_s * step.mean.angular_velocity_rps;
    duration_s += step.duration_s;
  }
  const Vector3d seen_rps = LogSO3(moved.rotation) / duration_s;
  ++turns_;
  axes_.Add(seen_rps, felt_rad / duration_s);
  clock_.AddTurn(before.timestamp_ns, seen.timestamp_ns, seen_rps);
}

void InertialOdometry::Judge(const Seen& seen, double distance) {
  was_far_.push_back(distance > kUsualDistance);
  if (was_far_.size() < kNewest) return;
  if (was_far_.size() > kNewest) was_far_.pop_front();
  if (ShareFar() <= kMostFar) return;
  if (CorrectClock()) {
    Begin(seen);
    return;
  }
  const std::optional<AxesFit> fit = axes_.Fit();
  const auto why = fit.has_value() ? ImuAxes::Describe(*fit) : std::nullopt;
  Doubt(InertialDoubt::Kind::kContradicts,
        why.value_or("what the IMU feels and what the camera sees contradict: are "
                     "imu_from_camera, the units and the noise of the IMU right?"));
  // Perhaps it was but for a while.
  least_time_s_ *= kMoreTime;
  Begin(seen);
}

bool InertialOdometry::CorrectClock() {
  const std::optional<ClockFit> fit = clock_.Fit();
  if (!fit.has_value()) return false;
  // The one that was found before is not in the samples as they came.
  if (std::abs(fit->offset_ns - offset_ns_) < kSameOffset_ns) return false;
  offset_ns_ = fit->offset_ns;
  buffer_ = ImuBuffer();
  buffer_.Add(Shifted(clock_.samples(), offset_ns_));
  axes_ = ImuAxes();
  const double offset_s = 1e-9 * static_cast<double>(offset_ns_);
  // What is stamped late comes with later frames than those of its time.
  const bool comes_late = offset_ns_ < -ImuBuffer::kLongestStep_ns;
  constexpr char kComesLate[] =
      ". Until then its samples come too late to say where the camera is while pictures don't";
  Doubt(InertialDoubt::Kind::kLate,
        absl::StrFormat("the IMU's stamps are %.3f s %s against the pictures', by when both turn "
                        "(correlation %.2f for %.2f as stamped). They are taken so from now on: "
                        "put the time_offset_s of the rig's IMU right by %+.3f%s",
                        std::abs(offset_s), offset_s < 0 ? "late" : "early", fit->correlation,
                        fit->correlation_as_stamped, offset_s, comes_late ? kComesLate : ""));
  return true;
}

double InertialOdometry::ShareFar() const {
  const auto far = std::count(was_far_.begin(), was_far_.end(), true);
  return static_cast<double>(far) / static_cast<double>(was_far_.size());
}

bool InertialOdometry::IsReady() const {
  if (!filter_.has_value() || was_far_.size() < kLeastJudged) return false;
  if (turns_ < kLeastTurns) return false;
  if (1e-9 * static_cast<double>(filter_ns_ - began_ns_) < least_time_s_) return false;
  if (ShareFar() > kMostFarWhenReady) return false;
  return Sigma(*filter_, InertialFilter::kVelocity) < kWellKnown_mps &&
         Sigma(*filter_, InertialFilter::kGyro) < kWellKnown_rps &&
         DownSigma_rad(*filter_) < kWellKnownDown_rad;
}

std::optional<InertialMotion> InertialOdometry::Since(int64_t timestamp_ns) const {
  if (!IsReady() || !last_.has_value() || timestamp_ns - last_->timestamp_ns > kLongest_ns) {
    return std::nullopt;
  }
  constexpr int64_t kChunk_ns = 200'000'000;
  InertialFilter filter = *filter_;
  int64_t now_ns = filter_ns_;
  const auto go_on_to = [&](int64_t to_ns) {
    const bool has_come = to_ns == now_ns || !GoOn(now_ns, to_ns, filter).empty();
    now_ns = to_ns;
    return has_come;
  };
  for (const Seen& seen : pending_) {
    if (!go_on_to(seen.timestamp_ns)) return std::nullopt;
    filter.Update(seen.pose);
  }
  while (now_ns < timestamp_ns) {
    if (!go_on_to(std::min(now_ns + kChunk_ns, timestamp_ns))) return std::nullopt;
    if (now_ns - last_->timestamp_ns >= kChunk_ns && IsStill(now_ns, filter)) filter.UpdateStill();
  }
  InertialMotion motion;
  motion.since_ns = timestamp_ns - last_->timestamp_ns;
  const Rigid3d imu_previous_from_imu =
      last_->pose.odom_from_imu.Inverse() * filter.odom_from_imu();
  motion.camera_from_previous =
      imu_from_camera_.Inverse() * imu_previous_from_imu.Inverse() * imu_from_camera_;
  // The lever arm adds what the turn is uncertain by, which is small beside the rest.
  const Matrix3d previous_from_odom =
      (last_->pose.odom_from_imu.rotation * imu_from_camera_.rotation)
          .conjugate()
          .toRotationMatrix();
  const Matrix3d previous_from_imu =
      previous_from_odom * filter.odom_from_imu().rotation.toRotationMatrix();
  const auto block = [&](int row, int column) {
    return filter.covariance().block<3, 3>(row, column);
  };
  const double off_m =
      kSpeedOff * filter_->velocity_mps().norm() * 1e-9 * static_cast<double>(motion.since_ns);
  motion.covariance.topLeftCorner<3, 3>() =
      previous_from_odom * block(InertialFilter::kPosition, InertialFilter::kPosition) *
          previous_from_odom.transpose() +
      off_m * off_m * Matrix3d::Identity();
  motion.covariance.bottomRightCorner<3, 3>() =
      previous_from_imu * block(InertialFilter::kTurn, InertialFilter::kTurn) *
      previous_from_imu.transpose();
  motion.covariance.topRightCorner<3, 3>() =
      previous_from_odom * block(InertialFilter::kPosition, InertialFilter::kTurn) *
      previous_from_imu.transpose();
  motion.covariance.bottomLeftCorner<3, 3>() = motion.covariance.topRightCorner<3, 3>().transpose();
  return motion;
}

bool InertialOdometry::IsStill(int64_t until_ns, const InertialFilter& filter) const {
  // What rolls on evenly feels as what stands does.
  const double speed = filter.velocity_mps().norm();
  if (speed > 0.05 + 3 * Sigma(filter, InertialFilter::kVelocity)) return false;
  const std::vector<ImuStep> steps = buffer_.Between(until_ns - kStill_ns, until_ns);
  if (steps.empty()) return false;
  const Vector3d mean = MeanForce(steps);
  return std::ranges::all_of(steps, [&](const ImuStep& step) {
    const Vector3d turning = step.mean.angular_velocity_rps - filter.biases().gyro_rps;
    return turning.norm() < kStill_rps &&
           (step.mean.specific_force_mps2 - mean).norm() < kStill_mps2;
  });
}

InertialState InertialOdometry::state() const {
  InertialState state;
  state.is_ready = IsReady();
  if (!filter_.has_value()) return state;
  const Eigen::Quaterniond camera_from_odom =
      (filter_->odom_from_imu().rotation * imu_from_camera_.rotation).conjugate();
  if (const double sigma_rad = DownSigma_rad(*filter_); sigma_rad < kWellKnownDown_rad) {
    state.down = Down{camera_from_odom * filter_->gravity_mps2().normalized(), sigma_rad};
  }
  state.biases = filter_->biases();
  state.late_s = filter_->late_s();
  state.noisier = filter_->noisier();
  state.late_sigma_s =
      std::sqrt(filter_->covariance()(InertialFilter::kLate, InertialFilter::kLate));
  return state;
}

void InertialOdometry::Doubt(InertialDoubt::Kind kind, std::string text) {
  if (std::ranges::find(told_, kind) != told_.end()) return;
  told_.push_back(kind);
  doubts_.push_back({kind, std::move(text)});
}

}  // namespace corbslam
