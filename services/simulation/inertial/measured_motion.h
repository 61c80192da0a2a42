// Says what an ideal IMU measures of a motion that is a function of time.
//
// The world's frame is that of scene.h: y points down, as gravity does.
#ifndef CORBSLAM_SERVICES_SIMULATION_INERTIAL_MEASURED_MOTION_H_
#define CORBSLAM_SERVICES_SIMULATION_INERTIAL_MEASURED_MOTION_H_

#include <cstdint>
#include <functional>

#include "slam/geometry/rigid3.h"
#include "slam/inertial/imu.h"

namespace corbslam {

// Nanoseconds, both ends included.
struct TimeSpan {
  int64_t first_ns = 0;
  int64_t last_ns = -1;
};

// Returns world_from_imu at a time in nanoseconds.
using ImuMotion = std::function<Rigid3d(int64_t time_ns)>;

// Returns the samples k / rate_hz within the span, outside of which `motion` is not looked at.
//
// A sample is the mean over one period about its time, as of an IMU that integrates: angular
// velocity is the turn over the period, acceleration the change of velocity. So the samples' sum
// is the motion's even where its acceleration jumps, as it does at the poses of a PoseSequence.
ImuSamples MeasureMotion(const ImuMotion& motion, const TimeSpan& span, double rate_hz);

// Returns the motion's velocity in the world at a time of the span, m/s.
Eigen::Vector3d VelocityAt(const ImuMotion& motion, const TimeSpan& span, int64_t time_ns);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_INERTIAL_MEASURED_MOTION_H_
