#include "client_agent/source/calibration/stated_imu.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/source/calibration/plausibility.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr double kMostRate_hz = 20'000;
// Farther apart, the IMU is hardly on the robot's own frame.
constexpr double kLongLever_m = 2;

absl::Status CheckAbove0(absl::string_view field, std::optional<double> value, double most,
                         absl::string_view unit) {
  if (!value.has_value() || (*value > 0 && *value <= most)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("imu.", field, " is ", *value,
                                                 ", must be above 0 and at most ", most, " ", unit,
                                                 *value == 0 ? ": leave it out where nobody knows "
                                                               "it, then that of a cheap IMU is "
                                                               "taken"
                                                             : ""));
}

}  // namespace

absl::Status Validate(const StatedImu& imu) {
  RETURN_IF_ERROR(CheckAbove0("rate_hz", imu.rate_hz, kMostRate_hz, "Hz"));
  RETURN_IF_ERROR(CheckAbove0("gyro_noise", imu.gyro_noise, 1000, "rad/s/sqrt(Hz)"));
  RETURN_IF_ERROR(CheckAbove0("accel_noise", imu.accel_noise, 1000, "m/s2/sqrt(Hz)"));
  RETURN_IF_ERROR(CheckAbove0("gyro_walk", imu.gyro_walk, 1000, "rad/s2/sqrt(Hz)"));
  RETURN_IF_ERROR(CheckAbove0("accel_walk", imu.accel_walk, 1000, "m/s3/sqrt(Hz)"));
  if (std::abs(imu.time_offset_s) <= kMostImuOffset_s) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("imu.time_offset_s is ", imu.time_offset_s, ", must be at most ",
                   kMostImuOffset_s, ": is it in seconds, and have IMU and camera one clock?"));
}

absl::StatusOr<SourceFindings> JudgeImu(const StatedImu& imu, absl::string_view from, bool trust) {
  ASSIGN_OR_RETURN(SourceFindings findings, CheckImuNumbers(imu, from, trust));
  const double lever_m = imu.imu_from_camera.translation.norm();
  if (lever_m > kLongLever_m) {
    findings.push_back({FindingLevel::kWarning, "calibration-improbable",
                        absl::StrCat(from, ": the IMU is ", lever_m,
                                     " m from the camera, which is improbable: is it in metres?")});
  }
  return findings;
}

ImuCalibration CalibrationOf(const StatedImu& imu) {
  ImuCalibration calibration;
  ImuNoise& noise = calibration.noise;
  noise.gyro = imu.gyro_noise.value_or(noise.gyro);
  noise.accel = imu.accel_noise.value_or(noise.accel);
  noise.gyro_walk = imu.gyro_walk.value_or(noise.gyro_walk);
  noise.accel_walk = imu.accel_walk.value_or(noise.accel_walk);
  calibration.imu_from_camera = imu.imu_from_camera;
  calibration.rate_hz = imu.rate_hz.value_or(calibration.rate_hz);
  calibration.time_offset_s = imu.time_offset_s;
  return calibration;
}

StatedImu StatedOf(const ImuCalibration& imu) {
  return {imu.imu_from_camera, imu.rate_hz,          imu.noise.gyro,   imu.noise.accel,
          imu.noise.gyro_walk, imu.noise.accel_walk, imu.time_offset_s};
}

}  // namespace corbslam::client_agent
