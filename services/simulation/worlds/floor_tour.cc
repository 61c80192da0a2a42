#include <algorithm>
#include <limits>
#include <vector>

#include "services/simulation/dice.h"
#include "services/simulation/worlds/floor_plan.h"

namespace corbslam {
namespace {

using Eigen::Vector2d;
using Kind = FloorNode::Kind;

constexpr uint64_t kTourDice = 301;

// Returns the nodes after `from` up to `to`, by the shortest way (Dijkstra; a floor has some dozens
// of nodes).
std::vector<int> WayBetween(const FloorLanes& lanes, int from, int to) {
  const size_t count = lanes.nodes.size();
  std::vector<double> distance(count, std::numeric_limits<double>::max());
  std::vector<int> previous(count, -1);
  std::vector<bool> done(count, false);
  distance[static_cast<size_t>(from)] = 0;
  for (size_t round = 0; round < count; ++round) {
    size_t nearest = count;
    for (size_t i = 0; i < count; ++i) {
      if (!done[i] && (nearest == count || distance[i] < distance[nearest])) nearest = i;
    }
    done[nearest] = true;
    for (const int next : lanes.neighbours[nearest]) {
      const auto other = static_cast<size_t>(next);
      const double way =
          distance[nearest] + (lanes.nodes[other].at - lanes.nodes[nearest].at).norm();
      if (way >= distance[other]) continue;
      distance[other] = way;
      previous[other] = static_cast<int>(nearest);
    }
  }
  std::vector<int> way;
  for (int node = to; node != from && node >= 0; node = previous[static_cast<size_t>(node)]) {
    way.push_back(node);
  }
  std::reverse(way.begin(), way.end());
  return way;
}

int FindNode(const FloorLanes& lanes, Kind kind, int room, int corridor, bool last) {
  int found = -1;
  for (size_t i = 0; i < lanes.nodes.size(); ++i) {
    const FloorNode& node = lanes.nodes[i];
    if (node.kind != kind || node.corridor != corridor || (room >= 0 && node.room != room))
      continue;
    found = static_cast<int>(i);
    if (!last) break;
  }
  return found;
}

// Picks any of a row's rooms with two doors.
int RoomToCross(const FloorPlan& plan, const FloorLanes& lanes, int row, Dice* dice) {
  std::vector<int> rooms;
  for (int column = 0; column < plan.options.rooms_x; ++column) {
    const int room = row * plan.options.rooms_x + column;
    if (FindNode(lanes, Kind::kCorridor, room, row + 1, false) >= 0) rooms.push_back(room);
  }
  return rooms[static_cast<size_t>(dice->Integer(0, static_cast<int>(rooms.size()) - 1))];
}

}  // namespace

std::vector<Eigen::Vector2d> TourOfFloor(const FloorPlan& plan, uint64_t seed) {
  const FloorLanes lanes = LanesOf(plan);
  Dice dice = Dice::For(seed, kTourDice, 0);
  const auto junction = [&](int corridor, bool right) {
    return FindNode(lanes, Kind::kJunction, -1, corridor, right);
  };
  // The tour goes down the rows: along the corridor to one end, through a room to the next, then to
  // the other end.
  std::vector<int> targets = {junction(0, false), junction(0, true)};
  bool right = true;
  for (int row = 0; row < plan.options.rooms_z; ++row) {
    const int room = RoomToCross(plan, lanes, row, &dice);
    targets.push_back(room);
    targets.push_back(FindNode(lanes, Kind::kCorridor, room, row + 1, false));
    targets.push_back(junction(row + 1, right));
    targets.push_back(junction(row + 1, !right));
    right = !right;
  }
  // It goes back to the start, and along the first corridor once more.
  targets.push_back(junction(0, false));
  targets.push_back(junction(0, true));
  std::vector<Vector2d> tour = {lanes.nodes[static_cast<size_t>(targets[0])].at};
  int at = targets[0];
  for (const int target : targets) {
    for (const int node : WayBetween(lanes, at, target)) {
      tour.push_back(lanes.nodes[static_cast<size_t>(node)].at);
    }
    at = target;
  }
  return tour;
}

}  // namespace corbslam
