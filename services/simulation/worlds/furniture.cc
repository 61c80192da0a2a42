#include "services/simulation/worlds/furniture.h"

#include <cmath>
#include <numbers>

#include "services/simulation/dice.h"
#include "services/simulation/worlds/mesh_shapes.h"

namespace corbslam {
namespace {

using Eigen::Vector3f;

// Half extents across and along the way that a piece faces, and its height.
struct Extent {
  float x;
  float z;
  float height;
};

Extent ExtentOf(const Furniture& furniture) {
  const Eigen::Vector2d half = (furniture.footprint.high - furniture.footprint.low) / 2;
  const bool turned = furniture.quarter_turns % 2 == 1;
  return {static_cast<float>(turned ? half.y() : half.x()),
          static_cast<float>(turned ? half.x() : half.y()), static_cast<float>(furniture.height_m)};
}

void AddShelf(const Extent& e, Dice* dice, Mesh* mesh) {
  const Finish wood = {Material::kWood, dice->Seed(), dice->Uniformf(0.7, 1.4)};
  const float board = 0.025F;
  AddBox({-e.x, -e.height, -e.z}, {-e.x + board, 0, e.z}, wood, mesh);
  AddBox({e.x - board, -e.height, -e.z}, {e.x, 0, e.z}, wood, mesh);
  AddBox({-e.x, -e.height, -e.z}, {e.x, -e.height + board, e.z}, wood, mesh);
  const float books = e.z - 0.06F;
  const float tone = dice->Uniformf(0.7, 1.3);
  mesh->patches.push_back(Rectangle({-e.x + board, -e.height + board, books},
                                    {2 * (e.x - board), 0, 0}, {0, e.height - board, 0},
                                    Material::kShelf, dice->Seed(), tone));
  // Boards stand out before the books, at the pattern's own distance.
  for (float y = -e.height + board; y < -0.05F; y += 0.35F) {
    AddBox({-e.x + board, y, books}, {e.x - board, y + 0.03F, e.z}, wood, mesh, true);
  }
}

void AddLegs(const Extent& e, float top, float half, const Finish& finish, Mesh* mesh) {
  for (const float x : {-e.x + half, e.x - half}) {
    for (const float z : {-e.z + half, e.z - half}) {
      AddBox({x - half, top, z - half}, {x + half, 0, z + half}, finish, mesh);
    }
  }
}

void AddTable(const Extent& e, Dice* dice, Mesh* mesh) {
  const Finish top = {Material::kWood, dice->Seed(), dice->Uniformf(0.7, 1.5)};
  AddBox({-e.x, -e.height, -e.z}, {e.x, -e.height + 0.04F, e.z}, top, mesh, true);
  AddLegs(e, -e.height + 0.04F, 0.025F, {Material::kMetal, dice->Seed(), 1}, mesh);
  const int things = dice->Integer(2, 6);
  for (int i = 0; i < things; ++i) {
    const float x = dice->Uniformf(-0.8, 0.8) * e.x;
    const float z = dice->Uniformf(-0.7, 0.6) * e.z;
    if (i == 0) {  // This is a screen.
      const float half = 0.27F;
      AddBox({x - half, -e.height - 0.42F, z - 0.02F}, {x + half, -e.height - 0.08F, z + 0.02F},
             {Material::kGlass, dice->Seed(), dice->Uniformf(0.5, 2)}, mesh, true);
      AddBox({x - 0.05F, -e.height - 0.1F, z - 0.05F}, {x + 0.05F, -e.height, z + 0.05F},
             {Material::kTyre, 1, 1}, mesh);
      continue;
    }
    const float half_x = dice->Uniformf(0.04, 0.16);
    const float half_z = dice->Uniformf(0.03, 0.11);
    const Finish cover = {dice->Chance(0.7) ? Material::kSign : Material::kCarPaint, dice->Seed(),
                          dice->Uniformf(0.5, 1.4)};
    AddBox({x - half_x, -e.height - dice->Uniformf(0.02, 0.28), z - half_z},
           {x + half_x, -e.height, z + half_z}, cover, mesh);
  }
}

void AddChair(const Extent& e, Dice* dice, Mesh* mesh) {
  const Finish seat = {dice->Chance(0.5) ? Material::kWood : Material::kCarpet, dice->Seed(),
                       dice->Uniformf(0.6, 1.4)};
  AddBox({-e.x, -0.47F, -e.z}, {e.x, -0.43F, e.z}, seat, mesh, true);
  AddBox({-e.x, -e.height, -e.z}, {e.x, -0.62F, -e.z + 0.04F}, seat, mesh, true);
  AddLegs(e, -0.43F, 0.018F, {Material::kMetal, dice->Seed(), 0.8F}, mesh);
  for (const float x : {-e.x, e.x - 0.03F}) {
    AddBox({x, -0.65F, -e.z}, {x + 0.03F, -0.45F, -e.z + 0.03F}, seat, mesh);
  }
}

void AddCabinet(const Extent& e, Dice* dice, Mesh* mesh) {
  const Finish body = {dice->Chance(0.5) ? Material::kMetal : Material::kWood, dice->Seed(),
                       dice->Uniformf(0.7, 1.4)};
  AddBox({-e.x, -e.height, -e.z}, {e.x, 0, e.z - 0.02F}, body, mesh);
  const int doors = e.x > 0.45F ? 2 : 1;
  const float width = 2 * e.x / static_cast<float>(doors);
  for (int i = 0; i < doors; ++i) {
    const float left = -e.x + width * static_cast<float>(i);
    AddBox({left + 0.01F, -e.height + 0.01F, e.z - 0.02F}, {left + width - 0.01F, -0.06F, e.z},
           {Material::kDoor, body.seed + 1, body.tone}, mesh);
    AddBox({left + width / 2 - 0.06F, -0.6F * e.height, e.z},
           {left + width / 2 + 0.06F, -0.6F * e.height + 0.02F, e.z + 0.03F},
           {Material::kTyre, 1, 1}, mesh, true);
  }
  const int things = dice->Integer(0, 3);
  for (int i = 0; i < things && e.height < 1.6F; ++i) {
    const float x = dice->Uniformf(-0.7, 0.7) * e.x;
    const Finish cover = {Material::kSign, dice->Seed(), dice->Uniformf(0.5, 1.4)};
    AddBox({x - 0.08F, -e.height - dice->Uniformf(0.1, 0.35), -0.1F}, {x + 0.08F, -e.height, 0.1F},
           cover, mesh);
  }
}

void AddPlant(const Extent& e, Dice* dice, Mesh* mesh) {
  AddTube({0, 0, 0}, {0, -0.3F, 0}, 0.7F * e.x, 0.85F * e.x, 8,
          {Material::kPlaster, dice->Seed(), dice->Uniformf(0.5, 1.4)}, mesh);
  AddDisc({0, -0.27F, 0}, -Vector3f::UnitY(), 0.8F * e.x, {Material::kBark, 1, 0.5F}, mesh);
  for (int i = 0; i < 70; ++i) {  // The leaves are long and hang outward.
    const float angle = dice->Uniformf(0, 2 * std::numbers::pi);
    const Vector3f out(std::cos(angle), 0, std::sin(angle));
    const Vector3f side(-out.z(), 0, out.x());
    const float up = dice->Uniformf(0.35, 1) * e.height;
    const Vector3f root = Vector3f(0, -up, 0) + 0.25F * e.x * dice->Uniformf(0, 1) * out;
    const Vector3f tip = root + 0.75F * e.x * dice->Uniformf(0.5, 1) * out +
                         Vector3f(0, dice->Uniformf(-0.15, 0.2), 0);
    const Vector3f middle = 0.5F * (root + tip);
    const float half = dice->Uniformf(0.02, 0.06);
    AddQuad(root, middle - half * side, tip, middle + half * side,
            {Material::kLeaves, dice->Seed(), dice->Uniformf(0.5, 1.3)}, mesh);
  }
  AddTube({0, -0.2F, 0}, {0, -0.9F * e.height, 0}, 0.02F, 0.01F, 4, {Material::kBark, 2, 1}, mesh);
}

}  // namespace

Mesh BuildFurniture(const Furniture& furniture) {
  Mesh mesh;
  Dice dice(furniture.seed);
  const Extent extent = ExtentOf(furniture);
  switch (furniture.kind) {
    case FurnitureKind::kShelf:
      AddShelf(extent, &dice, &mesh);
      break;
    case FurnitureKind::kTable:
      AddTable(extent, &dice, &mesh);
      break;
    case FurnitureKind::kChair:
      AddChair(extent, &dice, &mesh);
      break;
    case FurnitureKind::kCabinet:
      AddCabinet(extent, &dice, &mesh);
      break;
    case FurnitureKind::kPlant:
      AddPlant(extent, &dice, &mesh);
      break;
  }
  return mesh;
}

}  // namespace corbslam
