// Ground truth as instruments give it: satellite and inertial sensors err slowly.
#ifndef CORBSLAM_SERVICES_SIMULATION_SEQUENCE_TRUTH_ERROR_H_
#define CORBSLAM_SERVICES_SIMULATION_SEQUENCE_TRUTH_ERROR_H_

#include <cstdint>

#include "slam/geometry/rigid3.h"

namespace corbslam {

struct TruthError {
  double position_m = 0;       // Standard deviation over time, along each axis.
  double orientation_deg = 0;  // Standard deviation over time, about each axis.
  uint64_t seed = 1;
};

// Returns the pose that the instrument reports: each of the six errors is a sum of three
// oscillations with periods of 11 to 83 s and phases of the seed. Pure.
Rigid3d MeasuredPose(const Rigid3d& world_from_camera, double time_s, const TruthError& error);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SEQUENCE_TRUTH_ERROR_H_
