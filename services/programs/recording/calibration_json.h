// Writes a sensor's calibration as JSON and reads the same one back, to the bit: rig files give
// motions back up to rounding only.
#ifndef CORBSLAM_SERVICES_PROGRAMS_RECORDING_CALIBRATION_JSON_H_
#define CORBSLAM_SERVICES_PROGRAMS_RECORDING_CALIBRATION_JSON_H_

#include <nlohmann/json.hpp>

#include "absl/status/statusor.h"
#include "client_agent/source/rig/rig.h"
#include "slam/sensor/sensor.h"

namespace corbslam::services {

// Motions are [qw, qx, qy, qz, x, y, z]. The mask, a picture, is left out.
nlohmann::ordered_json ToJson(const SensorCalibration& calibration);
nlohmann::ordered_json ToJson(const Rigid3d& motion);

// DATA_LOSS names what is missing or of another kind. The result has no mask.
absl::StatusOr<SensorCalibration> CalibrationFromJson(const nlohmann::ordered_json& json);
absl::StatusOr<Rigid3d> RigidFromJson(const nlohmann::ordered_json& json);

// Returns the rig of which CalibrationOf makes this calibration, up to rounding; without the file
// of a mask.
client_agent::Rig RigOf(const SensorCalibration& calibration);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_RECORDING_CALIBRATION_JSON_H_
