// Says when something that drives, walks or flies along a path is where.
#ifndef CORBSLAM_SERVICES_SIMULATION_MOTION_TRAVEL_H_
#define CORBSLAM_SERVICES_SIMULATION_MOTION_TRAVEL_H_

#include <Eigen/Core>
#include <vector>

#include "services/simulation/motion/plane_path.h"

namespace corbslam {

struct TravelLimits {
  double speed_mps = 12;
  double accelerate_mps2 = 1.5;
  double brake_mps2 = 2.5;
  double lateral_mps2 = 2.0;      // Speed squared times the path's curvature.
  double yaw_rate_radps = 1.2;    // Speed times the change of heading.
  double least_speed_mps = 0.05;  // This limit goes before the others.
};

struct TravelSample {
  double time_s = 0;
  double distance_m = 0;
  Eigen::Vector2d position;  // (x, z)
  double heading_rad = 0;
  double speed_mps = 0;
  double forward_mps2 = 0;
  double lateral_mps2 = 0;  // Acceleration to the right.
};

// Returns samples 1 / rate_hz apart from the path's start, at speed, to its end. `speeds_mps`, when
// not empty, has a further limit for each point of the path. An empty path has no samples.
std::vector<TravelSample> SampleTravel(const PlanePath& path, const TravelLimits& limits,
                                       double rate_hz, const std::vector<double>& speeds_mps = {});

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_MOTION_TRAVEL_H_
