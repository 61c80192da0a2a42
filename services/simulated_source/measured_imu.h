// Takes what a real IMU measured into a simulation (docs/simulation.md).
#ifndef CORBSLAM_SERVICES_SIMULATED_SOURCE_MEASURED_IMU_H_
#define CORBSLAM_SERVICES_SIMULATED_SOURCE_MEASURED_IMU_H_

#include <string>

#include "absl/status/statusor.h"
#include "services/simulation/inertial/simulated_imu.h"

namespace corbslam::services {

// Returns `imu` with the samples of a file in EuRoC's form in the place of simulated ones. Errors
// are those of ReadImuList; INVALID_ARGUMENT also for what it only warns of.
absl::StatusOr<SimulatedImu> ReadMeasuredImu(const std::string& path, SimulatedImu imu);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SIMULATED_SOURCE_MEASURED_IMU_H_
