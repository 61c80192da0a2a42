// What calibration files state of an IMU, which may be less than an estimator needs.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_STATED_IMU_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_STATED_IMU_H_

#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/source/source_finding.h"
#include "slam/geometry/rigid3.h"
#include "slam/inertial/imu.h"

namespace corbslam::client_agent {

// IMU and camera have one clock to this; more is another clock, or another unit.
inline constexpr double kMostImuOffset_s = 0.5;

struct StatedImu {
  // x_in_imu = imu_from_camera * x_in_camera, metres; of the first camera as it recorded.
  Rigid3d imu_from_camera = {};
  std::optional<double> rate_hz = {};
  // Densities in the units of ImuNoise; absent: its own, of a cheap sensor.
  std::optional<double> gyro_noise = {};
  std::optional<double> accel_noise = {};
  std::optional<double> gyro_walk = {};
  std::optional<double> accel_walk = {};
  // What is added to its stamps to get times of the first camera's stamps.
  double time_offset_s = 0;
};

// INVALID_ARGUMENT names the field, its value and what an IMU has.
absl::Status Validate(const StatedImu& imu);

// Finds what is improbable; `from` names the file. What no IMU has is INVALID_ARGUMENT, unless
// `trust`.
absl::StatusOr<SourceFindings> JudgeImu(const StatedImu& imu, absl::string_view from, bool trust);

// Fills in what is not stated.
ImuCalibration CalibrationOf(const StatedImu& imu);
// States everything.
StatedImu StatedOf(const ImuCalibration& imu);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_STATED_IMU_H_
