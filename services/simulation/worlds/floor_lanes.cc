#include <algorithm>

#include "services/simulation/worlds/floor_plan.h"

namespace corbslam {
namespace {

using Eigen::Vector2d;
using Kind = FloorNode::Kind;

constexpr double kInsideM = 1.0;  // A walker goes so far into a room before turning.

int AddNode(const FloorNode& node, FloorLanes* lanes) {
  lanes->nodes.push_back(node);
  lanes->neighbours.emplace_back();
  return static_cast<int>(lanes->nodes.size()) - 1;
}

void Join(int a, int b, FloorLanes* lanes) {
  lanes->neighbours[static_cast<size_t>(a)].push_back(b);
  lanes->neighbours[static_cast<size_t>(b)].push_back(a);
}

// Adds the nodes of corridor `corridor` along x: its doors' places in order, between its two ends.
std::vector<int> CorridorNodes(const FloorPlan& plan, int corridor, const std::vector<int>& stops,
                               FloorLanes* lanes) {
  const size_t along_z = plan.corridors.size() - 2;
  const double z = Middle(plan.corridors[static_cast<size_t>(corridor)]).y();
  std::vector<int> row = stops;
  for (const size_t end : {along_z, along_z + 1}) {
    row.push_back(
        AddNode({Kind::kJunction, {Middle(plan.corridors[end]).x(), z}, -1, corridor}, lanes));
  }
  std::stable_sort(row.begin(), row.end(), [&](int a, int b) {
    return lanes->nodes[static_cast<size_t>(a)].at.x() <
           lanes->nodes[static_cast<size_t>(b)].at.x();
  });
  for (size_t i = 0; i + 1 < row.size(); ++i) Join(row[i], row[i + 1], lanes);
  return row;
}

}  // namespace

FloorLanes LanesOf(const FloorPlan& plan) {
  FloorLanes lanes;
  for (size_t i = 0; i < plan.rooms.size(); ++i) {
    AddNode({Kind::kHub, Middle(plan.rooms[i]), static_cast<int>(i), -1}, &lanes);
  }
  std::vector<std::vector<int>> stops(plan.corridors.size());
  for (const FloorDoor& door : plan.doors) {
    const bool front = door.at.y() < Middle(plan.rooms[static_cast<size_t>(door.room)]).y();
    const Vector2d inward(0, front ? kInsideM : -kInsideM);
    const int inside =
        AddNode({Kind::kDoorInside, door.at + inward, door.room, door.corridor}, &lanes);
    const double z = Middle(plan.corridors[static_cast<size_t>(door.corridor)]).y();
    const int outside =
        AddNode({Kind::kCorridor, {door.at.x(), z}, door.room, door.corridor}, &lanes);
    Join(door.room, inside, &lanes);
    Join(inside, outside, &lanes);
    stops[static_cast<size_t>(door.corridor)].push_back(outside);
  }
  std::vector<int> before;
  for (int corridor = 0; corridor <= plan.options.rooms_z; ++corridor) {
    const std::vector<int> row =
        CorridorNodes(plan, corridor, stops[static_cast<size_t>(corridor)], &lanes);
    if (!before.empty()) {
      Join(before.front(), row.front(), &lanes);
      Join(before.back(), row.back(), &lanes);
    }
    before = row;
  }
  return lanes;
}

}  // namespace corbslam
