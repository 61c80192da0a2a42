#include "slam/inertial/inertial_filter.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "slam/inertial/inertial_motion.h"

namespace corbslam {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Standard deviations at the start. Cheap IMUs have biases of so much.
constexpr double kVelocity_mps = 5;
constexpr double kGyroBias_rps = 0.05;
constexpr double kAccelBias_mps2 = 0.2;
constexpr double kFeltBesideGravity_mps2 = 3;
constexpr double kLate_s = 0.005;
// Gravity's length by place and height, and an accelerometer's scale.
constexpr double kGravityLength_mps2 = 0.03;
// What the odometry frame turns by as pictures drift, rad/sqrt(s); and the offset of time walks.
constexpr double kFrameTurns = 2e-4;
constexpr double kLateWalk = 1e-5;
// What an accelerometer's axes are off by in length and direction: as it turns, gravity shows in it
// as a bias that changes.
constexpr double kAxesOff = 0.007;
// Poses, too, are worse than they say where the IMU was noisier than it is said to be, up to this.
constexpr double kMostNoisierPoses = 4;

Matrix3d Square(double sigma) { return sigma * sigma * Matrix3d::Identity(); }

}  // namespace

InertialFilter::InertialFilter(const ImuNoise& noise, const SeenPose& start,
                               const Vector3d& specific_force_mps2)
    : noise_(noise), odom_from_imu_(start.odom_from_imu) {
  gravity_mps2_ = -(odom_from_imu_.rotation * specific_force_mps2).normalized() * kGravity_mps2;
  covariance_.block<3, 3>(kTurn, kTurn) = start.covariance.bottomRightCorner<3, 3>();
  covariance_.block<3, 3>(kPosition, kPosition) = start.covariance.topLeftCorner<3, 3>();
  covariance_.block<3, 3>(kVelocity, kVelocity) = Square(kVelocity_mps);
  covariance_.block<3, 3>(kGyro, kGyro) = Square(kGyroBias_rps);
  covariance_.block<3, 3>(kAccel, kAccel) = Square(kAccelBias_mps2);
  covariance_.block<3, 3>(kGravity, kGravity) = Square(kFeltBesideGravity_mps2);
  covariance_(kLate, kLate) = kLate_s * kLate_s;
}

// The sample is of the middle of the interval: so is the turn that its force acts at.
void InertialFilter::Propagate(const ImuSample& sample, double dt_s) {
  const Vector3d turning = sample.angular_velocity_rps - biases_.gyro_rps;
  const Vector3d force = sample.specific_force_mps2 - biases_.accel_mps2;
  const Eigen::Quaterniond halfway = odom_from_imu_.rotation * ExpSO3(0.5 * dt_s * turning);
  const Vector3d acceleration = halfway * force + gravity_mps2_;
  const Matrix3d turn = halfway.toRotationMatrix();

  Covariance step = Covariance::Identity();
  step.block<3, 3>(kTurn, kTurn) = ExpSO3(-dt_s * turning).toRotationMatrix();
  step.block<3, 3>(kTurn, kGyro) = -dt_s * Matrix3d::Identity();
  step.block<3, 3>(kVelocity, kTurn) = -dt_s * turn * Skew(force);
  step.block<3, 3>(kVelocity, kAccel) = -dt_s * turn;
  step.block<3, 3>(kVelocity, kGravity) = dt_s * Matrix3d::Identity();
  step.block<3, 3>(kPosition, kVelocity) = dt_s * Matrix3d::Identity();
  step.block<3, 3>(kPosition, kTurn) = 0.5 * dt_s * step.block<3, 3>(kVelocity, kTurn);
  step.block<3, 3>(kPosition, kAccel) = 0.5 * dt_s * step.block<3, 3>(kVelocity, kAccel);
  step.block<3, 3>(kPosition, kGravity) = 0.5 * dt_s * step.block<3, 3>(kVelocity, kGravity);
  covariance_ = (step * covariance_ * step.transpose()).eval();
  const auto grow = [&](int block, double density) {
    covariance_.diagonal().segment<3>(block).array() += density * density * dt_s;
  };
  grow(kTurn, noisier_ * noise_.gyro);
  grow(kVelocity, noisier_ * noise_.accel);
  grow(kGyro, noise_.gyro_walk);
  grow(kAccel, std::hypot(noise_.accel_walk, kAxesOff * kGravity_mps2 * turning.norm()));
  grow(kGravity, kFrameTurns * kGravity_mps2);
  covariance_(kLate, kLate) += kLateWalk * kLateWalk * dt_s;

  odom_from_imu_.translation += dt_s * velocity_mps_ + 0.5 * dt_s * dt_s * acceleration;
  velocity_mps_ += dt_s * acceleration;
  odom_from_imu_.rotation = (odom_from_imu_.rotation * ExpSO3(dt_s * turning)).normalized();
  angular_velocity_rps_ = turning;
}

double InertialFilter::Update(const SeenPose& seen) {
  Vector6d residual;
  residual << LogSO3(odom_from_imu_.rotation.conjugate() * seen.odom_from_imu.rotation),
      seen.odom_from_imu.translation - odom_from_imu_.translation;
  Eigen::Matrix<double, 6, kSize> jacobian = Eigen::Matrix<double, 6, kSize>::Zero();
  jacobian.block<3, 3>(0, kTurn).setIdentity();
  jacobian.block<3, 3>(3, kPosition).setIdentity();
  // Where samples are late, the state is of that much after the picture.
  jacobian.block<3, 1>(0, kLate) = -angular_velocity_rps_;
  jacobian.block<3, 1>(3, kLate) = -velocity_mps_;
  Matrix6d noise = Matrix6d::Zero();
  noise.topLeftCorner<3, 3>() = seen.covariance.bottomRightCorner<3, 3>();
  noise.bottomRightCorner<3, 3>() = seen.covariance.topLeftCorner<3, 3>();
  residual -= jacobian.col(kLate) * late_s_;
  noise *= std::pow(std::min(noisier_, kMostNoisierPoses), 2);
  const Matrix6d spread = jacobian * covariance_ * jacobian.transpose() + noise;
  const double distance = residual.dot(spread.ldlt().solve(residual));
  if (distance > kUsualDistance) noise *= distance / kUsualDistance;
  Correct<6>(residual, jacobian, noise);
  CorrectGravity();
  LearnNoise(distance);
  return distance;
}

// Distances are 6 in the mean where the noise is what it is taken to be.
void InertialFilter::LearnNoise(double distance) {
  constexpr double kRate = 0.02;
  constexpr double kMostNoisier = 10;
  const double excess = std::min(distance, 5 * 6.0) / 6 - 1;
  noisier_ = std::clamp(noisier_ * std::exp(kRate * excess), 1.0, kMostNoisier);
}

// Its length is known. The further off its direction may be, the less a length along the one that
// is believed says: by the second-order term.
void InertialFilter::CorrectGravity() {
  const double length = gravity_mps2_.norm();
  const Vector3d down = gravity_mps2_ / length;
  const Matrix3d spread = covariance_.block<3, 3>(kGravity, kGravity);
  const double across = spread.trace() - down.dot(spread * down);
  const double sigma = kGravityLength_mps2 + across / (2 * kGravity_mps2);
  Eigen::Matrix<double, 1, kSize> jacobian = Eigen::Matrix<double, 1, kSize>::Zero();
  jacobian.segment<3>(kGravity) = down.transpose();
  using One = Eigen::Matrix<double, 1, 1>;
  Correct<1>(One(kGravity_mps2 - length), jacobian, One(sigma * sigma));
}

void InertialFilter::UpdateStill() {
  constexpr double kStill_mps = 0.01;
  constexpr double kStill_rps = 0.01;
  Vector6d residual;
  residual << -velocity_mps_, -angular_velocity_rps_;
  Eigen::Matrix<double, 6, kSize> jacobian = Eigen::Matrix<double, 6, kSize>::Zero();
  jacobian.block<3, 3>(0, kVelocity).setIdentity();
  jacobian.block<3, 3>(3, kGyro) = -Matrix3d::Identity();
  Matrix6d noise = Matrix6d::Zero();
  noise.topLeftCorner<3, 3>() = Square(kStill_mps);
  noise.bottomRightCorner<3, 3>() = Square(kStill_rps);
  Correct<6>(residual, jacobian, noise);
}

void InertialFilter::Anchor() {
  const Matrix3d turned = covariance_.block<3, 3>(kTurn, kTurn);
  const auto pass_on = [&](int block, const Vector3d& of) {
    const Matrix3d by_turn = Skew(of) * odom_from_imu_.rotation.toRotationMatrix();
    covariance_.block<3, 3>(block, block) += by_turn * turned * by_turn.transpose();
  };
  pass_on(kVelocity, velocity_mps_);
  pass_on(kGravity, gravity_mps2_);
  for (const int block : {kTurn, kPosition}) {
    covariance_.middleRows<3>(block).setZero();
    covariance_.middleCols<3>(block).setZero();
  }
}

template <int kRows>
void InertialFilter::Correct(const Eigen::Matrix<double, kRows, 1>& residual,
                             const Eigen::Matrix<double, kRows, kSize>& jacobian,
                             const Eigen::Matrix<double, kRows, kRows>& noise) {
  const Eigen::Matrix<double, kSize, kRows> cross = covariance_ * jacobian.transpose();
  const Eigen::Matrix<double, kRows, kRows> spread = jacobian * cross + noise;
  const Eigen::Matrix<double, kSize, kRows> gain =
      spread.ldlt().solve(cross.transpose()).transpose();
  const Eigen::Matrix<double, kSize, 1> error = gain * residual;
  // Joseph's form stays positive.
  const Covariance kept = Covariance::Identity() - gain * jacobian;
  covariance_ = (kept * covariance_ * kept.transpose() + gain * noise * gain.transpose()).eval();
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
  odom_from_imu_.rotation =
      (odom_from_imu_.rotation * ExpSO3(error.segment<3>(kTurn))).normalized();
  odom_from_imu_.translation += error.segment<3>(kPosition);
  velocity_mps_ += error.segment<3>(kVelocity);
  biases_.gyro_rps += error.segment<3>(kGyro);
  biases_.accel_mps2 += error.segment<3>(kAccel);
  gravity_mps2_ += error.segment<3>(kGravity);
  late_s_ += error(kLate);
}

}  // namespace corbslam
