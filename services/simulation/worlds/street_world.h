// A street world built along a driven path: ground, kerbs, houses, trees, parked and moving cars.
//
// The path decides where the streets are; everything else comes from the seed. Nothing stands on
// any stretch of the path, however often and from whichever side the path comes by.
#ifndef CORBSLAM_SERVICES_SIMULATION_WORLDS_STREET_WORLD_H_
#define CORBSLAM_SERVICES_SIMULATION_WORLDS_STREET_WORLD_H_

#include <cstdint>
#include <vector>

#include "services/simulation/scene.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

struct StreetOptions {
  uint64_t seed = 1;
  double frame_rate_hz = 10;  // Pose i is taken at i / frame_rate_hz: when movers meet it.
  int moving_cars = 0;        // Oncoming, overtaking and leading ones, spread over the time.
  // Every street has the same few houses, cars and trees in the same order: places look alike that
  // aren't the same.
  bool look_alike = false;
};

// Poses are those of the left camera in the frame of scene.h, in the order they are taken, a frame
// apart. The same poses and options give the same scene to the bit. An empty path gives an empty
// scene. Pure.
Scene BuildStreetScene(const std::vector<Rigid3d>& world_from_camera, const StreetOptions& options);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_WORLDS_STREET_WORLD_H_
