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
  double top_speed_mps = 12;
  double hills_m = 2;  // Standard deviation of the ground's height, about.
  double sway = 1;     // Multiplies what the suspension does: pitch, roll, height.
  // How far the drive goes on behind the place where it began.
  double lead_out_m = 40;
};

// Drives along MakeStreetTour(seed, length_m), at kCarRate_hz. The first camera is at the origin of
// x and z and looks along z.
std::vector<Rigid3d> DriveThroughTown(const CarDriveOptions& options);

// Plans the same drive without what the suspension does: the bounds on speed and acceleration are
// about this.
std::vector<TravelSample> PlanDriveThroughTown(const CarDriveOptions& options);

struct WalkOptions {
  uint64_t seed = 1;
  double camera_height_m = 1.5;  // Height above the floor at y = 0.
  double speed_mps = 1.2;
  double look_around_rad = 0.35;  // Largest angle between the way and the camera, about.
  double bob = 1;                 // Multiplies what the steps do.
};

// Waypoints are (x, z). Poses come at kWalkerRate_hz.
std::vector<Rigid3d> WalkAlong(const std::vector<Eigen::Vector2d>& waypoints,
                               const WalkOptions& options);

struct FlightOptions {
  uint64_t seed = 1;
  double lowest_m = 0.9;  // Height above the floor at y = 0 wanders between these.
  double highest_m = 1.9;
  double speed_mps = 1.5;
};

// Poses come at kDroneRate_hz. The drone banks into turns and tilts with its acceleration.
std::vector<Rigid3d> FlyAlong(const std::vector<Eigen::Vector2d>& waypoints,
                              const FlightOptions& options);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_MOTION_DRIVES_H_
