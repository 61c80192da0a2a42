// Makes an indoor floor: rooms left and right of corridors, with furniture, and a walk through it.
//
// The frame is that of scene.h: x right, y down, z forward. The floor lies at y = 0, the ceiling at
// y = -kWallHeightM.
#ifndef CORBSLAM_SERVICES_SIMULATION_WORLDS_FLOOR_WORLD_H_
#define CORBSLAM_SERVICES_SIMULATION_WORLDS_FLOOR_WORLD_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "services/simulation/scene.h"

namespace corbslam {

struct FloorOptions {
  uint64_t seed = 1;
  int rooms_x = 4;  // Rooms of a row, at least 1.
  int rooms_z = 3;  // Rows of rooms, at least 1; a corridor runs before and behind each.
  // Two corridors, the second and the third, have the same surfaces, doors and furniture: a trap
  // for place recognition. It takes three rows of rooms at least.
  bool look_alike_corridors = false;
};

// An upright box of the floor plan, in metres of the plane (x, z).
struct FloorBox {
  Eigen::Vector2d low;
  Eigen::Vector2d high;
};

enum class FurnitureKind : uint8_t { kShelf, kTable, kChair, kCabinet, kPlant };

struct Furniture {
  FurnitureKind kind = FurnitureKind::kShelf;
  FloorBox footprint;
  double height_m = 1;
  int quarter_turns = 0;  // Which way it faces: 0 to +z, then +x, -z, -x.
  uint32_t seed = 0;
};

struct Poster {
  Eigen::Vector2d centre;
  Eigen::Vector2d along;  // Unit vector of the wall that it hangs on.
  double width_m = 0.8;
  double height_m = 1.0;
  double middle_m = 1.6;  // Height of its middle above the floor.
  uint32_t seed = 0;
};

// A wall from one end to the other along its middle, kWallM thick.
struct Wall {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
  bool doorway = false;  // The wall reaches from the lintel to the ceiling only.
  bool windows = false;  // True for an outer wall.
  // Seeds of the side that (-z, x) of the direction (x, z) points to, and of the other.
  std::array<uint32_t, 2> seeds = {};
};
constexpr double kWallM = 0.12;
constexpr double kWallHeightM = 2.8;
constexpr double kDoorwayM = 1.0;
constexpr double kDoorHeightM = 2.1;

struct FloorDoor {
  Eigen::Vector2d at;  // Middle of the doorway, in the wall.
  int room = 0;
  int corridor = 0;
};

struct FloorPlan {
  FloorOptions options;
  FloorBox outline;
  std::vector<FloorBox> rooms;      // Row by row, rooms_x to the row.
  std::vector<FloorBox> corridors;  // Those along x, front to back, then the two along z.
  std::vector<FloorDoor> doors;
  std::vector<Wall> walls;
  std::vector<Furniture> furniture;
  std::vector<Poster> posters;
};

// The walk's straight lines keep this far from furniture.
constexpr double kFloorClearanceM = 0.4;

// The plan depends on the options alone; counts below 1 are taken as 1. This function is pure, as
// are the other two.
FloorPlan MakeFloorPlan(const FloorOptions& options);

Scene BuildFloorScene(const FloorPlan& plan);

// Returns waypoints (x, z) in metres of a walk that comes through every corridor along x and
// through rooms, comes back to where it began and passes some places twice. Straight lines between
// the waypoints stay 0.4 m off walls and furniture.
std::vector<Eigen::Vector2d> TourOfFloor(const FloorPlan& plan, uint64_t seed);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_WORLDS_FLOOR_WORLD_H_
