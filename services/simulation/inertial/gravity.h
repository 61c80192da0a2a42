// Finds which way is down in the frame of a path along which a real IMU measured.
#ifndef CORBSLAM_SERVICES_SIMULATION_INERTIAL_GRAVITY_H_
#define CORBSLAM_SERVICES_SIMULATION_INERTIAL_GRAVITY_H_

#include "absl/status/statusor.h"
#include "services/simulation/inertial/measured_motion.h"

namespace corbslam {

// Returns gravity in the frame of `motion` (frame_from_imu), m/s2: that which, with constant
// biases, makes the sums of the samples over half seconds fit the motion's velocities best.
// INVALID_ARGUMENT where the samples can't be of this motion: fewer than three seconds of them
// within the span, a gravity of another length than the earth's, or accelerations that differ.
// Poses of another body than the IMU, clocks that differ and wrong units are such cases.
absl::StatusOr<Eigen::Vector3d> EstimateGravity(const ImuMotion& motion, const TimeSpan& span,
                                                const ImuSamples& samples);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_INERTIAL_GRAVITY_H_
