// Builds cars as prototypes, to be parked and to be driven.
#ifndef CORBSLAM_SERVICES_SIMULATION_WORLDS_CARS_H_
#define CORBSLAM_SERVICES_SIMULATION_WORLDS_CARS_H_

#include <cstdint>
#include <vector>

#include "services/simulation/scene.h"

namespace corbslam {

struct CarPrototype {
  Mesh mesh;  // The origin is on the ground below the middle, z points ahead, y down.
  float length = 4.2F;
  float width = 1.76F;
};

// Builds a hatchback, saloon, estate, van, off-roader and a small car.
std::vector<CarPrototype> BuildCarPrototypes(uint64_t seed);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_WORLDS_CARS_H_
