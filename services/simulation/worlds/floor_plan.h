// Declares the steps of MakeFloorPlan. Internal to services/simulation/worlds.
#ifndef CORBSLAM_SERVICES_SIMULATION_WORLDS_FLOOR_PLAN_H_
#define CORBSLAM_SERVICES_SIMULATION_WORLDS_FLOOR_PLAN_H_

#include <Eigen/Core>
#include <vector>

#include "services/simulation/worlds/floor_world.h"

namespace corbslam {

// A straight line that people walk along.
struct FloorLane {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
};

// A place that lanes meet at.
struct FloorNode {
  enum class Kind { kJunction, kCorridor, kDoorInside, kHub };
  Kind kind = Kind::kHub;
  Eigen::Vector2d at;
  int room = -1;
  int corridor = -1;
};

// Where one can walk: corridors' middles, doorways, rooms' middles.
struct FloorLanes {
  std::vector<FloorNode> nodes;
  std::vector<std::vector<int>> neighbours;
};
FloorLanes LanesOf(const FloorPlan& plan);

// Puts furniture and posters into the plan, off the lanes.
void Furnish(FloorPlan* plan);

// Returns which corridor a corridor looks like: itself, but for look-alike ones.
inline int AppearanceOf(const FloorOptions& options, int corridor) {
  return options.look_alike_corridors && corridor == 2 ? 1 : corridor;
}

inline Eigen::Vector2d Middle(const FloorBox& box) { return (box.low + box.high) / 2; }

double DistanceBetween(const FloorLane& lane, const FloorBox& box);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_WORLDS_FLOOR_PLAN_H_
