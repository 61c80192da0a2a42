#include <algorithm>
#include <cmath>

#include "services/simulation/dice.h"
#include "services/simulation/worlds/floor_plan.h"

namespace corbslam {
namespace {

using Eigen::Vector2d;

constexpr uint64_t kRoomDice = 201;
constexpr uint64_t kCorridorDice = 202;
constexpr uint64_t kPosterDice = 203;

// The distance is a little more than what is promised.
constexpr double kOffLanesM = kFloorClearanceM + 0.1;
constexpr double kBetweenM = 0.04;

struct Piece {
  FurnitureKind kind;
  double width;
  double depth;
  double height;
};

Piece PieceOf(FurnitureKind kind, Dice* dice) {
  switch (kind) {
    case FurnitureKind::kShelf:
      return {kind, dice->Uniform(0.8, 1.9), 0.34, dice->Uniform(1.5, 2.3)};
    case FurnitureKind::kTable:
      return {kind, dice->Uniform(1.2, 1.8), 0.75, 0.74};
    case FurnitureKind::kChair:
      return {kind, 0.46, 0.48, 0.92};
    case FurnitureKind::kCabinet:
      return {kind, dice->Uniform(0.6, 1.4), 0.42, dice->Uniform(0.9, 1.95)};
    case FurnitureKind::kPlant:
      return {kind, 0.5, 0.5, dice->Uniform(0.9, 1.8)};
  }
  return {kind, 1, 1, 1};
}

class Furnisher {
 public:
  explicit Furnisher(FloorPlan* plan) : plan_(plan) {
    const FloorLanes lanes = LanesOf(*plan);
    for (size_t i = 0; i < lanes.nodes.size(); ++i) {
      for (const int next : lanes.neighbours[i]) {
        const auto other = static_cast<size_t>(next);
        if (other > i) lanes_.push_back({lanes.nodes[i].at, lanes.nodes[other].at});
      }
    }
  }

  // Puts a piece with its back to the side that it faces away from: `turns` is as in Furniture.
  bool PutAtWall(const FloorBox& space, int turns, double share, const Piece& piece,
                 uint32_t seed) {
    const bool along_x = turns % 2 == 0;
    const Vector2d size =
        along_x ? Vector2d(piece.width, piece.depth) : Vector2d(piece.depth, piece.width);
    const Vector2d room = space.high - space.low - size - Vector2d::Constant(2 * kOffWallM);
    if (room.minCoeff() < 0) return false;
    Vector2d low = space.low + Vector2d::Constant(kOffWallM);
    const int along = along_x ? 0 : 1;
    low[along] += share * room[along];
    if (turns == 2 || turns == 3) low[1 - along] += room[1 - along];
    return Put({piece.kind, {low, low + size}, piece.height, turns, seed});
  }

  bool PutAt(const Vector2d& middle, int turns, const Piece& piece, uint32_t seed) {
    const Vector2d half = turns % 2 == 0 ? Vector2d(piece.width / 2, piece.depth / 2)
                                         : Vector2d(piece.depth / 2, piece.width / 2);
    return Put({piece.kind, {middle - half, middle + half}, piece.height, turns, seed});
  }

 private:
  static constexpr double kOffWallM = kWallM / 2 + 0.02;

  bool Put(const Furniture& piece) {
    for (const FloorLane& lane : lanes_) {
      if (DistanceBetween(lane, piece.footprint) < kOffLanesM) return false;
    }
    for (const Furniture& other : plan_->furniture) {
      const Vector2d gap = (piece.footprint.low - other.footprint.high)
                               .cwiseMax(other.footprint.low - piece.footprint.high);
      if (gap.maxCoeff() < kBetweenM) return false;
    }
    plan_->furniture.push_back(piece);
    return true;
  }

  FloorPlan* plan_;
  std::vector<FloorLane> lanes_;
};

FurnitureKind KindForWall(Dice* dice) {
  const double kind = dice->Uniform(0, 1);
  return kind < 0.42   ? FurnitureKind::kShelf
         : kind < 0.66 ? FurnitureKind::kCabinet
         : kind < 0.86 ? FurnitureKind::kTable
                       : FurnitureKind::kPlant;
}

void FurnishRoom(const FloorBox& room, int index, uint64_t seed, Furnisher* furnisher) {
  Dice dice = Dice::For(seed, kRoomDice, index);
  for (int attempt = 0; attempt < 26; ++attempt) {
    const Piece piece = PieceOf(KindForWall(&dice), &dice);
    const int turns = dice.Integer(0, 3);
    const double share = dice.Uniform(0, 1);
    const uint32_t own = dice.Seed();
    if (!furnisher->PutAtWall(room, turns, share, piece, own)) continue;
  }
  for (int attempt = 0; attempt < 14; ++attempt) {
    const double y = dice.Uniform(room.low.y() + 0.9, room.high.y() - 0.9);
    const Vector2d middle(dice.Uniform(room.low.x() + 0.9, room.high.x() - 0.9), y);
    const int turns = dice.Integer(0, 3);
    const bool table = attempt % 3 == 0;
    const Piece piece = PieceOf(table ? FurnitureKind::kTable : FurnitureKind::kChair, &dice);
    furnisher->PutAt(middle, turns, piece, dice.Seed());
  }
}

void FurnishCorridor(const FloorPlan& plan, int index, Furnisher* furnisher) {
  const FloorBox& corridor = plan.corridors[static_cast<size_t>(index)];
  const bool along_x = index <= plan.options.rooms_z;
  Dice dice = Dice::For(plan.options.seed, kCorridorDice, AppearanceOf(plan.options, index));
  const Vector2d size = corridor.high - corridor.low;
  const int attempts = static_cast<int>(size.maxCoeff() * 0.8);
  for (int attempt = 0; attempt < attempts; ++attempt) {
    const double kind = dice.Uniform(0, 1);
    const Piece piece = PieceOf(kind < 0.4   ? FurnitureKind::kShelf
                                : kind < 0.8 ? FurnitureKind::kCabinet
                                             : FurnitureKind::kPlant,
                                &dice);
    const int turns = dice.Integer(0, 1) * 2 + (along_x ? 0 : 1);
    const double share = dice.Uniform(0, 1);
    furnisher->PutAtWall(corridor, turns, share, piece, dice.Seed());
  }
}

// Walls of the same seed are hung the same way: look-alike corridors have the same posters.
void HangPosters(FloorPlan* plan) {
  for (const Wall& wall : plan->walls) {
    const Vector2d along = (wall.to - wall.from).normalized();
    const double length = (wall.to - wall.from).norm();
    if (wall.doorway || wall.windows || length < 1.3) continue;
    for (const size_t side : {size_t{0}, size_t{1}}) {
      Dice dice = Dice::For(plan->options.seed, kPosterDice, wall.seeds[side],
                            std::lround(100 * wall.from.x()));
      for (double at = dice.Uniform(0.7, 1.6); at < length - 0.7; at += dice.Uniform(1.2, 2)) {
        Poster poster;
        const Vector2d normal = (side == 0 ? 1.0 : -1.0) * Vector2d(-along.y(), along.x());
        poster.centre = wall.from + at * along + (kWallM / 2 + 0.02) * normal;
        poster.along = along;
        poster.width_m = dice.Uniform(0.35, 1.1);
        poster.height_m = dice.Uniform(0.35, 1.0);
        poster.middle_m = dice.Uniform(1.4, 1.8);
        poster.seed = dice.Seed();
        plan->posters.push_back(poster);
      }
    }
  }
}

}  // namespace

void Furnish(FloorPlan* plan) {
  Furnisher furnisher(plan);
  for (size_t i = 0; i < plan->rooms.size(); ++i) {
    FurnishRoom(plan->rooms[i], static_cast<int>(i), plan->options.seed, &furnisher);
  }
  for (size_t i = 0; i < plan->corridors.size(); ++i) {
    FurnishCorridor(*plan, static_cast<int>(i), &furnisher);
  }
  HangPosters(plan);
}

}  // namespace corbslam
