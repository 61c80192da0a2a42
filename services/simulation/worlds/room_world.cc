#include "services/simulation/worlds/room_world.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "services/simulation/dice.h"
#include "services/simulation/worlds/floor_plan.h"
#include "services/simulation/worlds/furniture.h"
#include "services/simulation/worlds/mesh_shapes.h"

namespace corbslam {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr uint64_t kSurfaceDice = 501;
constexpr uint64_t kWallDice = 502;
constexpr uint64_t kFurnitureDice = 503;

// y runs down: `low` is the corner at the ceiling.
struct RoomBox {
  Vector3d low;
  Vector3d high;
};

// The way that the inner side of each wall looks, as Furniture::quarter_turns.
constexpr double kFacing[][2] = {{0, 1}, {1, 0}, {0, -1}, {-1, 0}};

class RoomBuilder {
 public:
  RoomBuilder(const std::vector<Rigid3d>& poses, uint64_t seed) : poses_(poses), seed_(seed) {
    room_ = {poses.front().translation, poses.front().translation};
    for (const Rigid3d& pose : poses) {
      room_.low = room_.low.cwiseMin(pose.translation);
      room_.high = room_.high.cwiseMax(pose.translation);
    }
    room_.low -= Vector3d::Constant(kRoomMarginM);
    room_.high += Vector3d::Constant(kRoomMarginM);
  }

  Scene Build() {
    Scene scene;
    scene.seed = static_cast<uint32_t>(seed_);
    scene.light.sky = false;
    scene.light.ambient = 0.7F;
    scene.light.towards_sun = Vector3f(0.3F, -0.8F, -0.52F).normalized();
    AddFloorAndCeiling();
    for (int wall = 0; wall < 4; ++wall) AddWall(wall);
    Furnish();
    scene.meshes.push_back(mesh_);
    scene.instances.emplace_back();
    return scene;
  }

 private:
  double height_m() const { return room_.high.y() - room_.low.y(); }
  Vector3f At(const Vector2d& plane, double above_floor_m) const {
    return Vector3d(plane.x(), room_.high.y() - above_floor_m, plane.y()).cast<float>();
  }
  Vector2d LowCorner() const { return {room_.low.x(), room_.low.z()}; }
  Vector2d Size() const { return {room_.high.x() - room_.low.x(), room_.high.z() - room_.low.z()}; }

  void AddFloorAndCeiling() {
    Dice dice = Dice::For(seed_, kSurfaceDice, 0);
    const Vector3f x(static_cast<float>(Size().x()), 0, 0);
    const Vector3f z(0, 0, static_cast<float>(Size().y()));
    mesh_.patches.push_back(
        Rectangle(At(LowCorner(), 0), x, z, Material::kCarpet, dice.Seed(), 1.1F));
    mesh_.patches.push_back(
        Rectangle(At(LowCorner(), height_m()), x, z, Material::kCeiling, dice.Seed()));
  }

  // Returns where on its floor a wall begins, and the unit vector along it.
  std::pair<Vector2d, Vector2d> LineOf(int wall) const {
    const Vector2d facing(kFacing[wall][0], kFacing[wall][1]);
    const Vector2d along(facing.y(), -facing.x());
    const Vector2d half = Size() / 2;
    return {LowCorner() + half - half.cwiseProduct(facing) - half.cwiseProduct(along), along};
  }

  // A wall of pieces that differ, with pillars between them and posters on them.
  void AddWall(int wall) {
    static constexpr Material kMaterials[] = {Material::kWallpaper, Material::kBrick,
                                              Material::kPlaster};
    const auto [from, along] = LineOf(wall);
    const Vector2d facing(kFacing[wall][0], kFacing[wall][1]);
    const double length_m = std::abs(along.dot(Size()));
    Dice dice = Dice::For(seed_, kWallDice, wall);
    double end_m = 0;
    for (double at_m = 0; at_m < length_m; at_m = end_m) {
      end_m = std::min(at_m + dice.Uniform(1.6, 2.8), length_m);
      const Material material = kMaterials[dice.Integer(0, 2)];
      const uint32_t seed = dice.Seed();
      AddUpright(from + at_m * along, (end_m - at_m) * along, 0, height_m(),
                 {material, seed, dice.Uniformf(0.8, 1.3)});
      AddPosters(from + at_m * along + 0.01 * facing, (end_m - at_m) * along, &dice);
      AddPillar(from + end_m * along, facing, &dice);
    }
  }

  void AddUpright(const Vector2d& from, const Vector2d& along, double low_m, double high_m,
                  const Finish& finish) {
    const Vector3f edge = Vector3d(along.x(), 0, along.y()).cast<float>();
    const Vector3f down(0, static_cast<float>(high_m - low_m), 0);
    mesh_.patches.push_back(
        Rectangle(At(from, high_m), edge, down, finish.material, finish.seed, finish.tone));
  }

  void AddPosters(const Vector2d& from, const Vector2d& along, Dice* dice) {
    for (double middle_m = 0.6; middle_m + 0.5 < height_m(); middle_m += 0.9) {
      if (dice->Chance(0.3)) continue;
      const double share = dice->Uniform(0.1, 0.5);
      const double half_m = dice->Uniform(0.2, 0.4);
      const uint32_t seed = dice->Seed();
      AddUpright(from + share * along, 0.35 * along, middle_m - half_m, middle_m + half_m,
                 {Material::kSign, seed, dice->Uniformf(0.8, 1.3)});
    }
  }

  void AddPillar(const Vector2d& at, const Vector2d& facing, Dice* dice) {
    const Vector2d reach = Vector2d(0.1, 0.1) + 0.1 * facing.cwiseAbs();
    AddBox(At(at - reach, height_m()), At(at + reach, 0), {Material::kWood, dice->Seed(), 1.1F},
           &mesh_);
  }

  bool IsClear(const FloorBox& place, double height_m) const {
    const double top_y = room_.high.y() - height_m - kRoomClearanceM;
    return std::none_of(poses_.begin(), poses_.end(), [&](const Rigid3d& pose) {
      const Vector2d at(pose.translation.x(), pose.translation.z());
      const Vector2d beyond = (place.low - at).cwiseMax(at - place.high).cwiseMax(0);
      return pose.translation.y() > top_y && beyond.norm() < kRoomClearanceM;
    });
  }

  void Furnish() {
    static constexpr FurnitureKind kKinds[] = {FurnitureKind::kShelf, FurnitureKind::kCabinet,
                                               FurnitureKind::kTable, FurnitureKind::kChair,
                                               FurnitureKind::kPlant};
    constexpr double kHeights[] = {2.0, 1.3, 0.74, 0.92, 1.2};
    constexpr double kWidths[] = {1.3, 1.0, 1.5, 0.46, 0.5};
    constexpr double kDepths[] = {0.34, 0.42, 0.75, 0.48, 0.5};
    Dice dice = Dice::For(seed_, kFurnitureDice, 0);
    const int attempts = static_cast<int>(6 * Size().x() * Size().y());
    for (int i = 0; i < attempts && i < 2000; ++i) {
      const auto kind = static_cast<size_t>(dice.Integer(0, 4));
      Furniture piece;
      piece.kind = kKinds[kind];
      piece.height_m = std::min(kHeights[kind], height_m() - 0.3);
      piece.quarter_turns = dice.Integer(0, 3);
      piece.seed = dice.Seed();
      const Vector2d size = piece.quarter_turns % 2 == 0 ? Vector2d(kWidths[kind], kDepths[kind])
                                                         : Vector2d(kDepths[kind], kWidths[kind]);
      const double x = dice.Uniform(0, 1);
      const Vector2d share(x, dice.Uniform(0, 1));
      piece.footprint.low = LowCorner() + Vector2d::Constant(0.25) +
                            share.cwiseProduct(Size() - size - Vector2d::Constant(0.5));
      piece.footprint.high = piece.footprint.low + size;
      PutIfFree(piece);
    }
  }

  void PutIfFree(const Furniture& piece) {
    if (!IsClear(piece.footprint, piece.height_m)) return;
    for (const FloorBox& other : taken_) {
      const Vector2d gap =
          (piece.footprint.low - other.high).cwiseMax(other.low - piece.footprint.high);
      if (gap.maxCoeff() < 0.05) return;
    }
    taken_.push_back(piece.footprint);
    const auto& turn = kFacing[piece.quarter_turns];
    AppendMoved(BuildFurniture(piece),
                Upright(At(Middle(piece.footprint), 0).cast<double>(), {turn[0], turn[1]}), &mesh_);
  }

  const std::vector<Rigid3d>& poses_;
  const uint64_t seed_;
  RoomBox room_;
  Mesh mesh_;
  std::vector<FloorBox> taken_;
};

}  // namespace

Scene BuildRoomScene(const std::vector<Rigid3d>& world_from_camera, uint64_t seed) {
  return RoomBuilder(world_from_camera, seed).Build();
}

}  // namespace corbslam
