// Builds pieces of furniture as meshes.
#ifndef CORBSLAM_SERVICES_SIMULATION_WORLDS_FURNITURE_H_
#define CORBSLAM_SERVICES_SIMULATION_WORLDS_FURNITURE_H_

#include "services/simulation/scene.h"
#include "services/simulation/worlds/floor_world.h"

namespace corbslam {

// The mesh has its origin on the floor in the middle of the footprint, y down, the front towards
// +z.
Mesh BuildFurniture(const Furniture& furniture);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_WORLDS_FURNITURE_H_
