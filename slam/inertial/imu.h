// What an inertial measurement unit measures, and what is known of it.
//
// An IMU's axes are those of its gyroscope and accelerometer, right-handed. At rest it measures a
// specific force of 9.8 m/s2 upwards: what holds it up.
#ifndef CORBSLAM_SLAM_INERTIAL_IMU_H_
#define CORBSLAM_SLAM_INERTIAL_IMU_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "slam/geometry/rigid3.h"

namespace corbslam {

// Length of the acceleration of gravity, m/s2: within 0.3 % of it from equator to pole.
constexpr double kGravity_mps2 = 9.80665;

struct ImuSample {
  int64_t timestamp_ns = 0;
  Eigen::Vector3d angular_velocity_rps = Eigen::Vector3d::Zero();  // rad/s
  // Acceleration less gravity, m/s2.
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Zero();
};

// In the order of time, no two of one time.
using ImuSamples = std::vector<ImuSample>;

// Densities of white noise and of the walk of biases, as Kalibr and EuRoC's sensor.yaml have them.
struct ImuNoise {
  double gyro = 1.7e-3;      // rad/s/sqrt(Hz)
  double accel = 2e-2;       // m/s2/sqrt(Hz)
  double gyro_walk = 2e-5;   // rad/s2/sqrt(Hz)
  double accel_walk = 3e-3;  // m/s3/sqrt(Hz)
};

struct ImuCalibration {
  ImuNoise noise;
  // x_in_imu = imu_from_camera * x_in_camera, metres; the camera is the first one as it recorded.
  Rigid3d imu_from_camera;
  double rate_hz = 200;
  // What is added to the IMU's stamps to get times of the camera's clock (less Kalibr's
  // timeshift_cam_imu).
  double time_offset_s = 0;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_INERTIAL_IMU_H_
