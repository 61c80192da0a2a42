// Declares the parts that BuildHouse puts together, in the frame of house.h.
#ifndef CORBSLAM_SERVICES_SIMULATION_WORLDS_HOUSE_PARTS_H_
#define CORBSLAM_SERVICES_SIMULATION_WORLDS_HOUSE_PARTS_H_

#include "services/simulation/dice.h"
#include "services/simulation/scene.h"
#include "services/simulation/worlds/house.h"
#include "services/simulation/worlds/mesh_shapes.h"

namespace corbslam {

inline float EavesM(const HouseStyle& style) {
  return kPlinthM + kStoreyM * static_cast<float>(style.storeys);
}

// Adds windows, door with steps, balconies and bay of the front.
void AddFront(const HouseStyle& style, const Finish& wall, Dice* dice, Mesh* mesh);

// Adds roof, gables, dormers, chimneys and gutters.
void AddRoof(const HouseStyle& style, const Finish& wall, Dice* dice, Mesh* mesh);

// A window that stands out of the wall z = `z` a little; (x, y) is its upper left corner.
struct WindowShape {
  float width = 1.2F;
  float height = 1.4F;
  bool shutters = false;
  bool cross = false;  // True: bars go both ways, otherwise there is one upright.
  Finish frame = {Material::kPlaster, 0, 1.4F};
  uint32_t seed = 0;
};
void AddWindow(const WindowShape& shape, float x, float y, float z, Mesh* mesh);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_WORLDS_HOUSE_PARTS_H_
