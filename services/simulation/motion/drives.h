// Says how a car, a walker and a drone carry their camera along a way.
//
// The frame is that of scene.h: x right, y DOWN, z forward. Poses are world_from_camera of a camera
// that looks along the way. The same options give the same poses to the bit.
#ifndef CORBSLAM_SERVICES_SIMULATION_MOTION_DRIVES_H_
#define CORBSLAM_SERVICES_SIMULATION_MOTION_DRIVES_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "services/simulation/motion/travel.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

inline constexpr double kCarRate_hz = 10;
inline constexpr double kWalkerRate_hz = 30;
inline constexpr double kDroneRate_hz = 20;

struct CarDriveOptions {
  uint64_t seed = 1;
  double length_m = 1500;
};

// Drives along MakeStreetTour(seed, length_m) and 40 m on behind its end, at kCarRate_hz. The first
// camera is at the origin of x and z and looks along z.
std::vector<Rigid3d> DriveThroughTown(const CarDriveOptions& options);

// Plans the same drive without what the suspension does: the bounds on speed and acceleration are
// about this.
std::vector<TravelSample> PlanDriveThroughTown(const CarDriveOptions& options);

// Waypoints are (x, z). The camera is 1.5 m above the floor at y = 0. Poses come at kWalkerRate_hz.
std::vector<Rigid3d> WalkAlong(const std::vector<Eigen::Vector2d>& waypoints, uint64_t seed);

// Poses come at kDroneRate_hz. The drone banks into turns and tilts with its acceleration; its
// height above the floor at y = 0 wanders between 0.9 and 1.9 m.
std::vector<Rigid3d> FlyAlong(const std::vector<Eigen::Vector2d>& waypoints, uint64_t seed);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_MOTION_DRIVES_H_
