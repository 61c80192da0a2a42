// Builds trees, bushes and hedges as prototypes, to be placed many times.
#ifndef CORBSLAM_SERVICES_SIMULATION_WORLDS_PLANTS_H_
#define CORBSLAM_SERVICES_SIMULATION_WORLDS_PLANTS_H_

#include <cstdint>
#include <vector>

#include "services/simulation/scene.h"

namespace corbslam {

// The origin is at the foot, y points down. Heights are in metres.
struct TreeShape {
  float height = 8;
  float trunk = 2.4F;  // The trunk is bare up to here.
  float crown_radius = 2.6F;
  float trunk_radius = 0.17F;
  int branches = 8;
  int clumps = 380;
  float clump = 0.45F;  // Mean size of a clump of leaves.
  bool conifer = false;
};
Mesh BuildTree(const TreeShape& shape, uint64_t seed);

// Builds a round bush, whose radius is as wide as it is high.
Mesh BuildBush(float radius, int clumps, uint64_t seed);

// Builds a clipped hedge along x from 0 to `length`, its middle at z = 0.
Mesh BuildHedge(float length, float height, float thickness, uint64_t seed);

// Street trees come first (round crowns over a bare trunk), then garden trees (all sorts).
struct TreePrototypes {
  std::vector<Mesh> street;
  std::vector<Mesh> garden;
  std::vector<Mesh> bushes;
};
TreePrototypes BuildTreePrototypes(uint64_t seed);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_WORLDS_PLANTS_H_
