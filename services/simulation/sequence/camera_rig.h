// The cameras of simulated robots.
#ifndef CORBSLAM_SERVICES_SIMULATION_SEQUENCE_CAMERA_RIG_H_
#define CORBSLAM_SERVICES_SIMULATION_SEQUENCE_CAMERA_RIG_H_

#include <optional>

#include "services/simulation/sequence/simulation_spec.h"
#include "slam/camera/camera.h"
#include "slam/geometry/rigid3.h"
#include "slam/sensor/sensor.h"

namespace corbslam {

struct SimulatedRig {
  // What the robot is told.
  SensorCalibration calibration;
  // What the pictures are drawn with; both cameras of a pair have the same intrinsics. Of a
  // SimulationSpec::pair the size alone: its lenses draw.
  Camera camera;
  // Where the right camera really is; none: there is a depth image instead.
  std::optional<Rigid3d> left_from_right;
  double rate_hz = 10;
};

// The spec must be valid.
SimulatedRig MakeRig(const SimulationSpec& spec);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SEQUENCE_CAMERA_RIG_H_
