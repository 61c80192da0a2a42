#include "services/simulation/worlds/floor_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "services/simulation/dice.h"

namespace corbslam {
namespace {

using Eigen::Vector2d;

constexpr double kCorridorM = 2.4;

enum class FloorDice : uint64_t { kSizes = 101, kDoor, kRoomWall, kCorridorWall };

Dice DiceFor(const FloorOptions& options, FloorDice purpose, int a, int b = 0) {
  return Dice::For(options.seed, static_cast<uint64_t>(purpose), a, b);
}

std::vector<double> Divide(double start, int count, double low, double high, double between,
                           Dice* dice) {
  std::vector<double> starts;
  for (int i = 0; i < count; ++i) {
    starts.push_back(start);
    start += dice->Uniform(low, high) + between;
  }
  starts.push_back(start);
  return starts;
}

void LayOutRooms(FloorPlan* plan) {
  const FloorOptions& options = plan->options;
  Dice dice = DiceFor(options, FloorDice::kSizes, 0);
  const std::vector<double> xs = Divide(kCorridorM, options.rooms_x, 4.6, 7, 0, &dice);
  const std::vector<double> zs = Divide(kCorridorM, options.rooms_z, 4.4, 6.2, kCorridorM, &dice);
  plan->outline = {Vector2d::Zero(), {xs.back() + kCorridorM, zs.back()}};
  for (int row = 0; row < options.rooms_z; ++row) {
    const double back = zs[static_cast<size_t>(row) + 1] - kCorridorM;
    for (size_t column = 0; column + 1 < xs.size(); ++column) {
      plan->rooms.push_back({{xs[column], zs[static_cast<size_t>(row)]}, {xs[column + 1], back}});
    }
  }
  const double right = plan->outline.high.x();
  for (const double z : zs) {
    plan->corridors.push_back({{0, z - kCorridorM}, {right, z}});
  }
  plan->corridors.push_back({{0, 0}, {kCorridorM, plan->outline.high.y()}});
  plan->corridors.push_back({{right - kCorridorM, 0}, plan->outline.high});
}

// Every room has a front door; the first room of a row and most others have a back door.
void AddDoors(FloorPlan* plan) {
  const FloorOptions& options = plan->options;
  for (size_t i = 0; i < plan->rooms.size(); ++i) {
    const FloorBox& room = plan->rooms[i];
    const int row = static_cast<int>(i) / options.rooms_x;
    const int column = static_cast<int>(i) % options.rooms_x;
    // Look-alike corridors have their doors at the same places in every row.
    const int own = options.look_alike_corridors ? 0 : row;
    Dice dice = DiceFor(options, FloorDice::kDoor, own, column);
    const auto place = [&] { return dice.Uniform(room.low.x() + 1.1, room.high.x() - 1.1); };
    const double front = place();
    const double back = place();
    const int room_index = static_cast<int>(i);
    plan->doors.push_back({{front, room.low.y()}, room_index, row});
    if (column == 0 || options.look_alike_corridors || dice.Chance(0.65)) {
      plan->doors.push_back({{back, room.high.y()}, room_index, row + 1});
    }
  }
}

// Adds the wall of a room along x, with its doorway if it has one.
void AddWallWithDoor(const FloorBox& room, int room_index, int corridor, FloorPlan* plan) {
  const bool front = corridor == room_index / plan->options.rooms_x;
  const double z = front ? room.low.y() : room.high.y();
  const int column = room_index % plan->options.rooms_x;
  Dice inside = DiceFor(plan->options, FloorDice::kRoomWall, room_index);
  Dice outside = DiceFor(plan->options, FloorDice::kCorridorWall,
                         AppearanceOf(plan->options, corridor) * 2 + (front ? 1 : 0), column);
  const uint32_t room_seed = inside.Seed();
  const uint32_t corridor_seed = outside.Seed();
  // The direction +x has its first side at +z.
  const auto add = [&](double from, double to, bool doorway) {
    Wall wall;
    wall.from = {from, z};
    wall.to = {to, z};
    wall.doorway = doorway;
    wall.seeds = front ? std::array<uint32_t, 2>{room_seed, corridor_seed}
                       : std::array<uint32_t, 2>{corridor_seed, room_seed};
    plan->walls.push_back(wall);
  };
  double from = room.low.x();
  for (const FloorDoor& door : plan->doors) {
    if (door.room != room_index || door.corridor != corridor) continue;
    add(from, door.at.x() - kDoorwayM / 2, false);
    add(door.at.x() - kDoorwayM / 2, door.at.x() + kDoorwayM / 2, true);
    from = door.at.x() + kDoorwayM / 2;
  }
  add(from, room.high.x(), false);
}

void AddSideWall(const FloorBox& room, double x, uint32_t low_seed, uint32_t high_seed,
                 FloorPlan* plan) {
  Wall wall;
  wall.from = {x, room.low.y()};
  wall.to = {x, room.high.y()};
  wall.seeds = {low_seed, high_seed};  // The direction +z has its first side at -x.
  plan->walls.push_back(wall);
}

void AddWalls(FloorPlan* plan) {
  const FloorOptions& options = plan->options;
  const int columns = options.rooms_x;
  const auto room_seed = [&](int room) {
    return DiceFor(options, FloorDice::kRoomWall, room).Seed();
  };
  for (size_t i = 0; i < plan->rooms.size(); ++i) {
    const FloorBox& room = plan->rooms[i];
    const int index = static_cast<int>(i);
    const int row = index / columns;
    const int column = index % columns;
    AddWallWithDoor(room, index, row, plan);
    AddWallWithDoor(room, index, row + 1, plan);
    Dice corridor = DiceFor(options, FloorDice::kCorridorWall, 1000 + row, column);
    const uint32_t left = column == 0 ? corridor.Seed() : room_seed(index - 1);
    AddSideWall(room, room.low.x(), left, room_seed(index), plan);
    if (column + 1 == columns) {
      AddSideWall(room, room.high.x(), room_seed(index), corridor.Seed(), plan);
    }
  }
  const Vector2d low = plan->outline.low;
  const Vector2d high = plan->outline.high;
  const std::array<Vector2d, 5> corners = {low, Vector2d(high.x(), low.y()), high,
                                           Vector2d(low.x(), high.y()), low};
  for (size_t i = 0; i + 1 < corners.size(); ++i) {
    Wall wall;
    wall.from = corners[i];
    wall.to = corners[i + 1];
    wall.windows = true;
    const uint32_t seed =
        DiceFor(options, FloorDice::kCorridorWall, 2000, static_cast<int>(i)).Seed();
    wall.seeds = {seed, seed};
    plan->walls.push_back(wall);
  }
}

}  // namespace

double DistanceBetween(const FloorLane& lane, const FloorBox& box) {
  // The lane is sampled every few centimetres; lanes are short.
  const double length = (lane.to - lane.from).norm();
  const int steps = std::max(1, static_cast<int>(std::ceil(length / 0.05)));
  double nearest = std::numeric_limits<double>::max();
  for (int i = 0; i <= steps; ++i) {
    const Vector2d at = lane.from + (lane.to - lane.from) * i / steps;
    const Vector2d out = (box.low - at).cwiseMax(at - box.high).cwiseMax(0.0);
    nearest = std::min(nearest, out.norm());
  }
  return nearest;
}

FloorPlan MakeFloorPlan(const FloorOptions& options) {
  FloorPlan plan;
  plan.options = options;
  plan.options.rooms_x = std::max(1, options.rooms_x);
  plan.options.rooms_z = std::max(options.look_alike_corridors ? 3 : 1, options.rooms_z);
  LayOutRooms(&plan);
  AddDoors(&plan);
  AddWalls(&plan);
  Furnish(&plan);
  return plan;
}

}  // namespace corbslam
