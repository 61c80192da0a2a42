#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "services/simulation/dice.h"
#include "services/simulation/worlds/floor_plan.h"
#include "services/simulation/worlds/furniture.h"
#include "services/simulation/worlds/mesh_shapes.h"

namespace corbslam {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;

constexpr uint64_t kFloorDice = 401;
constexpr uint64_t kWindowDice = 402;

Vector3f At(const Vector2d& plane, double y) {
  return Eigen::Vector3d(plane.x(), y, plane.y()).cast<float>();
}

Finish FloorFinish(Dice* dice) {
  const double kind = dice->Uniform(0, 1);
  const Material material = kind < 0.4   ? Material::kCarpet
                            : kind < 0.7 ? Material::kFloorTiles
                                         : Material::kWood;
  return {material, dice->Seed(), dice->Uniformf(0.8, 1.3)};
}

// Adds floor, ceiling and the lamps below it.
void AddLevels(const FloorBox& box, const Finish& floor, uint32_t seed, Mesh* mesh) {
  const Vector2d size = box.high - box.low;
  const Vector3f x(static_cast<float>(size.x()), 0, 0);
  const Vector3f z(0, 0, static_cast<float>(size.y()));
  mesh->patches.push_back(Rectangle(At(box.low, 0), x, z, floor.material, floor.seed, floor.tone));
  mesh->patches.push_back(Rectangle(At(box.low, -kWallHeightM), x, z, Material::kCeiling, seed));
  const Vector2d half = size.x() > size.y() ? Vector2d(0.6, 0.15) : Vector2d(0.15, 0.6);
  const int count = std::max(1, static_cast<int>(size.maxCoeff() / 2.6));
  for (int i = 0; i < count; ++i) {
    const double share = (i + 0.5) / count;
    Vector2d at = Middle(box);
    const int along = size.x() > size.y() ? 0 : 1;
    at[along] = box.low[along] + share * size[along];
    AddBox(At(at - half, -kWallHeightM), At(at + half, -kWallHeightM + 0.08),
           {Material::kRoadMarking, seed, 1.5F}, mesh, true);
  }
}

// Adds one face of a wall between two heights above the floor; its texture hangs from the ceiling.
void AddFace(const Vector2d& from, const Vector2d& to, double low_m, double high_m,
             const Finish& finish, Mesh* mesh) {
  const Vector3f along = At(to - from, 0);
  const Vector3f down(0, static_cast<float>(high_m - low_m), 0);
  mesh->patches.push_back(
      Rectangle(At(from, -high_m), along, down, finish.material, finish.seed, finish.tone));
  mesh->patches.back().v_offset_m += static_cast<float>(kWallHeightM - high_m);
}

Finish WallFinish(uint32_t seed) {
  static constexpr Material kMaterials[] = {Material::kWallpaper, Material::kWallpaper,
                                            Material::kPlaster, Material::kBrick};
  return {kMaterials[seed % 4U], seed, 0.8F + 0.5F * static_cast<float>(seed / 4U % 64U) / 64.0F};
}

void AddDoorway(const Wall& wall, const Vector2d& normal, Mesh* mesh) {
  const Finish frame = {Material::kWood, wall.seeds[0], 1.2F};
  const double out = kWallM / 2 + 0.02;
  const double height = kDoorHeightM;
  const Vector2d along = (wall.to - wall.from).normalized();
  using Post = std::pair<Vector2d, Vector2d>;
  for (const auto& [post, inward] : {Post(wall.from, along), Post(wall.to, -along)}) {
    AddFace(post - out * normal, post + out * normal, 0, height, frame, mesh);
    for (const double side : {-1.0, 1.0}) {  // Adds what frames the opening on the wall's faces.
      AddFace(post + side * out * normal - 0.08 * inward, post + side * out * normal, 0,
              height + 0.08, frame, mesh);
    }
  }
  AddQuad(At(wall.from - out * normal, -height), At(wall.to - out * normal, -height),
          At(wall.to + out * normal, -height), At(wall.from + out * normal, -height), frame, mesh);
  for (const double side : {-1.0, 1.0}) {
    AddFace(wall.from + side * out * normal, wall.to + side * out * normal, height, height + 0.08,
            frame, mesh);
    const Vector2d plate = wall.to + side * out * normal + 0.2 * along;
    AddFace(plate, plate + 0.22 * along, 1.5, 1.62, {Material::kSign, wall.seeds[1], 1.4F}, mesh);
  }
}

// Adds panes with what is outside painted on them, and frames that stand out.
void AddWindows(const FloorPlan& plan, const Wall& wall, const Vector2d& normal, Mesh* mesh) {
  const Vector2d along = (wall.to - wall.from).normalized();
  const double length = (wall.to - wall.from).norm();
  Dice dice = Dice::For(plan.options.seed, kWindowDice, wall.seeds[0]);
  const double face = kWallM / 2;
  for (double at = 1.2; at + 1.6 < length; at += dice.Uniform(2.4, 4.2)) {
    const Vector2d from = wall.from + at * along + (face + 0.01) * normal;
    const Vector2d to = from + dice.Uniform(1.0, 1.5) * along;
    AddFace(from, to, 0.95, 2.3, {Material::kFacade, dice.Seed(), 1.5F}, mesh);
    const Finish frame = {Material::kMetal, dice.Seed(), 1.5F};
    const Vector2d out = 0.04 * normal;
    for (const double share : {0.0, 0.5, 1.0}) {
      const Vector2d bar = from + share * (to - from);
      AddFace(bar + out - 0.03 * along, bar + out + 0.03 * along, 0.95, 2.3, frame, mesh);
    }
    AddFace(from + out, to + out, 2.25, 2.32, frame, mesh);
    AddFace(from + 3 * out, to + 3 * out, 0.9, 0.96, frame, mesh);
    if (dice.Chance(0.6)) {  // This is a radiator.
      AddFace(from + 3 * out, to + 3 * out, 0.15, 0.75, {Material::kWood, frame.seed, 1.4F}, mesh);
    }
  }
}

void AddWall(const FloorPlan& plan, const Wall& wall, Mesh* mesh) {
  const Vector2d along = (wall.to - wall.from).normalized();
  const Vector2d normal(-along.y(), along.x());
  const double low = wall.doorway ? kDoorHeightM : 0;
  for (const size_t side : {size_t{0}, size_t{1}}) {
    const Vector2d out = (side == 0 ? 0.5 : -0.5) * kWallM * normal;
    AddFace(wall.from + out, wall.to + out, low, kWallHeightM, WallFinish(wall.seeds[side]), mesh);
  }
  if (wall.doorway) AddDoorway(wall, normal, mesh);
  if (wall.windows) AddWindows(plan, wall, normal, mesh);
}

void AddFloors(const FloorPlan& plan, Mesh* mesh) {
  const auto dice_for = [&](int which) { return Dice::For(plan.options.seed, kFloorDice, which); };
  for (size_t i = 0; i < plan.rooms.size(); ++i) {
    Dice dice = dice_for(static_cast<int>(i));
    const Finish floor = FloorFinish(&dice);
    AddLevels(plan.rooms[i], floor, dice.Seed(), mesh);
  }
  for (int i = 0; i <= plan.options.rooms_z; ++i) {
    Dice dice = dice_for(-1 - AppearanceOf(plan.options, i));
    const Finish floor = FloorFinish(&dice);
    AddLevels(plan.corridors[static_cast<size_t>(i)], floor, dice.Seed(), mesh);
  }
  // The corridors along z are laid in pieces between those along x.
  for (size_t side = plan.corridors.size() - 2; side < plan.corridors.size(); ++side) {
    Dice dice = dice_for(-1 - static_cast<int>(side));
    const Finish floor = FloorFinish(&dice);
    for (int row = 0; row < plan.options.rooms_z; ++row) {
      FloorBox piece = plan.corridors[side];
      const auto before = static_cast<size_t>(row);
      piece.low.y() = plan.corridors[before].high.y();
      piece.high.y() = plan.corridors[before + 1].low.y();
      AddLevels(piece, floor, dice.Seed(), mesh);
    }
  }
}

void AddPoster(const Poster& poster, Mesh* mesh) {
  const Vector2d half = poster.width_m / 2 * poster.along;
  const double low = poster.middle_m - poster.height_m / 2;
  AddFace(poster.centre - half, poster.centre + half, low, low + poster.height_m,
          {Material::kSign, poster.seed, 0.8F + static_cast<float>(poster.seed % 64U) / 128.0F},
          mesh);
}

}  // namespace

Scene BuildFloorScene(const FloorPlan& plan) {
  Scene scene;
  scene.seed = static_cast<uint32_t>(plan.options.seed);
  scene.light.sky = false;
  scene.light.ambient = 0.7F;
  scene.light.towards_sun = Vector3f(0.3F, -0.8F, -0.52F).normalized();
  scene.meshes.emplace_back();
  AddFloors(plan, &scene.meshes[0]);
  for (const Wall& wall : plan.walls) AddWall(plan, wall, &scene.meshes[0]);
  for (const Poster& poster : plan.posters) AddPoster(poster, &scene.meshes[0]);
  scene.instances.emplace_back();
  static constexpr double kTurns[][2] = {{0, 1}, {1, 0}, {0, -1}, {-1, 0}};
  for (const Furniture& piece : plan.furniture) {
    const auto& turn = kTurns[piece.quarter_turns % 4];
    const Vector2d at = Middle(piece.footprint);
    AppendMoved(BuildFurniture(piece), Upright({at.x(), 0, at.y()}, {turn[0], turn[1]}),
                &scene.meshes[0]);
  }
  return scene;
}

}  // namespace corbslam
