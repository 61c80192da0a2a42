#include "client_agent/source/calibration/imu_noise_fields.h"

#include "client_agent/source/calibration/yaml_numbers.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {

absl::StatusOr<std::optional<double>> ReadIfThere(const YAML::Node& file, const std::string& path,
                                                  const char* field) {
  const YAML::Node node = file[field];
  if (!node.IsDefined()) return std::nullopt;
  ASSIGN_OR_RETURN(const double number, ReadNumber(node, path, field));
  return number;
}

absl::Status ReadKalibrNoise(const YAML::Node& file, const std::string& path, StatedImu& imu) {
  ASSIGN_OR_RETURN(imu.gyro_noise, ReadIfThere(file, path, "gyroscope_noise_density"));
  ASSIGN_OR_RETURN(imu.accel_noise, ReadIfThere(file, path, "accelerometer_noise_density"));
  ASSIGN_OR_RETURN(imu.gyro_walk, ReadIfThere(file, path, "gyroscope_random_walk"));
  ASSIGN_OR_RETURN(imu.accel_walk, ReadIfThere(file, path, "accelerometer_random_walk"));
  return absl::OkStatus();
}

}  // namespace corbslam::client_agent
