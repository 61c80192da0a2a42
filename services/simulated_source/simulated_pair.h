// Takes the cameras of a simulated robot from a rig file (docs/rig.md).
#ifndef CORBSLAM_SERVICES_SIMULATED_SOURCE_SIMULATED_PAIR_H_
#define CORBSLAM_SERVICES_SIMULATED_SOURCE_SIMULATED_PAIR_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "services/simulation/sequence/simulation_spec.h"

namespace corbslam::services {

// Returns whether the value of rig= or imu= names a file: a path, or a name with a dot.
bool IsFile(absl::string_view value);

// Errors are those of ReadRigFile and CalibrationOf; INVALID_ARGUMENT names a file that is of no
// stereo pair, or whose pictures have two sizes.
absl::StatusOr<SimulatedPair> ReadSimulatedPair(const std::string& path);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SIMULATED_SOURCE_SIMULATED_PAIR_H_
