// Estimates what an IMU needs to be known of to go on by itself, velocity, gravity and biases, from
// its own samples and the poses that pictures give (an error-state Kalman filter; Sola, "Quaternion
// kinematics for the error-state Kalman filter", 2017; for poses as measurements Weiss and
// Siegwart, ICRA 2011).
//
// Poses are of the IMU in an odometry frame of the caller's choice, whose orientation to gravity is
// found out. The filter is never better than the pictures where they are good: it is for when they
// are not.
#ifndef CORBSLAM_SLAM_INERTIAL_INERTIAL_FILTER_H_
#define CORBSLAM_SLAM_INERTIAL_INERTIAL_FILTER_H_

#include <Eigen/Core>
#include <cstdint>

#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"
#include "slam/inertial/imu.h"

namespace corbslam {

struct ImuBiases {
  Eigen::Vector3d gyro_rps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_mps2 = Eigen::Vector3d::Zero();
};

// A pose that pictures gave, with its covariance ordered (translation, rotation): the translation's
// in the odometry frame's axes, the rotation's in the IMU's.
struct SeenPose {
  Rigid3d odom_from_imu;
  Matrix6d covariance = Matrix6d::Identity();
};

class InertialFilter {
 public:
  // Blocks of the error state; the last entry is the time offset's.
  enum Block { kTurn = 0, kVelocity = 3, kPosition = 6, kGyro = 9, kAccel = 12, kGravity = 15 };
  static constexpr int kLate = 18;
  static constexpr int kSize = 19;
  using Covariance = Eigen::Matrix<double, kSize, kSize>;

  // Begins at a pose that is known, with nothing known of velocity, and gravity against
  // `specific_force_mps2`, the mean of what the IMU felt about then: what it felt beside gravity is
  // taken to be some m/s2.
  InertialFilter(const ImuNoise& noise, const SeenPose& start,
                 const Eigen::Vector3d& specific_force_mps2);

  // Goes on for `dt_s` > 0 in which the IMU felt what `sample` says, in the mean.
  void Propagate(const ImuSample& sample, double dt_s);
  // Takes a pose that pictures gave of this time. Returns how far it was from what was expected:
  // the square of the Mahalanobis distance, of 6 degrees of freedom. One further than
  // kUsualDistance weighs accordingly less.
  double Update(const SeenPose& seen);
  // Takes it that the IMU does not move at this time.
  void UpdateStill();
  // Takes the present pose for known, and for what the odometry frame is told by from here on: what
  // was uncertain of it is so of gravity and velocity. For where pictures begin anew.
  void Anchor();

  const Rigid3d& odom_from_imu() const { return odom_from_imu_; }
  const Eigen::Vector3d& velocity_mps() const { return velocity_mps_; }  // In the odometry frame.
  const Eigen::Vector3d& gravity_mps2() const { return gravity_mps2_; }  // Likewise; downwards.
  const ImuBiases& biases() const { return biases_; }
  // How much later than its corrected stamps say the IMU measured, seconds.
  double late_s() const { return late_s_; }
  // How many times as noisy as it is said to be the IMU was lately, from 1 to 10: motors shake it.
  double noisier() const { return noisier_; }
  const Covariance& covariance() const { return covariance_; }

 private:
  template <int kRows>
  void Correct(const Eigen::Matrix<double, kRows, 1>& residual,
               const Eigen::Matrix<double, kRows, kSize>& jacobian,
               const Eigen::Matrix<double, kRows, kRows>& noise);
  void CorrectGravity();
  void LearnNoise(double distance);

  const ImuNoise noise_;
  Rigid3d odom_from_imu_;
  Eigen::Vector3d velocity_mps_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d gravity_mps2_;
  ImuBiases biases_;
  double late_s_ = 0;
  double noisier_ = 1;
  Eigen::Vector3d angular_velocity_rps_ = Eigen::Vector3d::Zero();  // The newest, without bias.
  Covariance covariance_ = Covariance::Zero();
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_INERTIAL_INERTIAL_FILTER_H_
