// Builds one house as a mesh.
#ifndef CORBSLAM_SERVICES_SIMULATION_WORLDS_HOUSE_H_
#define CORBSLAM_SERVICES_SIMULATION_WORLDS_HOUSE_H_

#include <cstdint>

#include "services/simulation/scene.h"

namespace corbslam {

enum class RoofKind : uint8_t {
  kRidgeAlongStreet,
  kGableToStreet,
  kHipped,
  kFlat,
};

// Everything that sets a house apart; lengths in metres.
struct HouseStyle {
  float width = 12;
  float depth = 10;
  int storeys = 2;
  RoofKind roof = RoofKind::kRidgeAlongStreet;
  float roof_pitch_rad = 0.7F;
  Material wall = Material::kPlaster;
  bool windows_in_relief = true;  // False: the front's windows are painted (kFacade).
  bool balconies = false;
  bool bay = false;      // A bay window over all storeys.
  bool dormers = false;  // Dormers stand on a ridge along the street.
  uint64_t seed = 1;     // Seed of surfaces and small things.
};

constexpr float kStoreyM = 3.0F;
constexpr float kPlinthM = 0.5F;
// Walls reach this far below the house's origin: it may stand on a slope.
constexpr float kFoundationM = 1.5F;

// The front's lower middle is the origin: x right for who looks at the front, y down, z into the
// house. Only the roof's edge, steps, balconies and the bay stand out before the front, by at most
// kHouseReliefM.
constexpr float kHouseReliefM = 1.3F;
Mesh BuildHouse(const HouseStyle& style);

HouseStyle RandomHouseStyle(uint64_t seed, double width_m, double depth_m);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_WORLDS_HOUSE_H_
