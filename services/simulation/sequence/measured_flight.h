// A path along which a real IMU moved, in a world that is upright for it.
#ifndef CORBSLAM_SERVICES_SIMULATION_SEQUENCE_MEASURED_FLIGHT_H_
#define CORBSLAM_SERVICES_SIMULATION_SEQUENCE_MEASURED_FLIGHT_H_

#include "absl/status/statusor.h"
#include "services/simulation/motion/pose_sequence.h"
#include "services/simulation/sequence/simulation_spec.h"
#include "slam/inertial/imu.h"

namespace corbslam {

struct MeasuredFlight {
  PoseSequence way;    // Of the camera; the world's y points down.
  ImuSamples samples;  // Those within the way, stamped from its first pose on.
};

// Reads the poses of the IMU, in any frame that does not turn, and makes the camera's of them.
// `spec` has an IMU that measured. INVALID_ARGUMENT names the files that don't fit (gravity.h);
// others are those of ReadTumTrajectory: the poses want times.
absl::StatusOr<MeasuredFlight> ReadMeasuredFlight(const SimulationSpec& spec);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SEQUENCE_MEASURED_FLIGHT_H_
