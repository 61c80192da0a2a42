// Reads an IMU's numbers by the names that Kalibr and EuRoC gave them.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_IMU_NOISE_FIELDS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_IMU_NOISE_FIELDS_H_

#include <yaml-cpp/yaml.h>

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client_agent/source/calibration/stated_imu.h"

namespace corbslam::client_agent {

// Returns nullopt where the field is not there. INVALID_ARGUMENT where it is no number.
absl::StatusOr<std::optional<double>> ReadIfThere(const YAML::Node& file, const std::string& path,
                                                  const char* field);

// Reads gyroscope_noise_density, accelerometer_noise_density, gyroscope_random_walk and
// accelerometer_random_walk, those that are there.
absl::Status ReadKalibrNoise(const YAML::Node& file, const std::string& path, StatedImu& imu);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_IMU_NOISE_FIELDS_H_
