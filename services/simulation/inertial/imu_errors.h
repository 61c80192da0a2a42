// Makes of what an ideal IMU measures what a real one says.
#ifndef CORBSLAM_SERVICES_SIMULATION_INERTIAL_IMU_ERRORS_H_
#define CORBSLAM_SERVICES_SIMULATION_INERTIAL_IMU_ERRORS_H_

#include <cstdint>

#include "services/simulation/inertial/simulated_imu.h"

namespace corbslam {

// Adds noise, biases and vibration, cuts off what is beyond the range, leaves out the gaps and
// makes the stamps late. `ideal` are the samples from the first on, stamped by the sequence's own
// time. The same seed gives the same errors to the bit.
ImuSamples WithErrors(const SimulatedImu& imu, uint64_t seed, ImuSamples ideal);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_INERTIAL_IMU_ERRORS_H_
