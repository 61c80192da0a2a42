#include <algorithm>

#include "services/simulation/worlds/house_parts.h"

namespace corbslam {
namespace {

using Eigen::Vector3f;

// Columns of windows across a front.
struct Columns {
  int count = 1;
  float pitch = 2;
  float first = 0;  // Middle of the leftmost column.

  float Middle(int column) const { return first + pitch * static_cast<float>(column); }
};

Columns DivideFront(const HouseStyle& style, Dice* dice) {
  Columns columns;
  const float wanted = dice->Uniformf(2.0, 3.1);
  columns.count = std::max(2, static_cast<int>((style.width - 0.8F) / wanted));
  columns.pitch = (style.width - 0.8F) / static_cast<float>(columns.count);
  columns.first = -style.width / 2 + 0.4F + columns.pitch / 2;
  return columns;
}

void AddDoor(float x, const Finish& wall, Dice* dice, Mesh* mesh) {
  const float half = dice->Uniformf(0.5, 0.75);
  const float height = dice->Uniformf(2.1, 2.6);
  const float top = -kPlinthM - height;
  AddBox({x - half - 0.15F, top - 0.15F, -0.1F}, {x + half + 0.15F, 0.3F, 0},
         {Material::kPlaster, dice->Seed(), dice->Uniformf(0.6, 1.4)}, mesh);
  const float tone = dice->Uniformf(0.5, 1.3);
  mesh->patches.push_back(Rectangle({x - half, top, -0.12F}, {2 * half, 0, 0}, {0, height, 0},
                                    Material::kDoor, dice->Seed(), tone));
  const Finish stone = {Material::kPavement, dice->Seed(), dice->Uniformf(0.7, 1.2)};
  for (int step = 0; step < 3; ++step) {
    const float rise = kPlinthM * static_cast<float>(3 - step) / 3;
    const float from = 0.3F * static_cast<float>(step);
    AddBox({x - half - 0.3F, -rise, -from - 0.4F}, {x + half + 0.3F, 0.5F, -from}, stone, mesh);
  }
  if (dice->Chance(0.6)) {
    AddBox({x - half - 0.4F, top - 0.4F, -0.95F}, {x + half + 0.4F, top - 0.25F, 0},
           {Material::kPlaster, wall.seed, 0.9F}, mesh, true);
  }
  // Letter boxes, a bell and a number hang beside the door.
  AddBox({x + half + 0.3F, -kPlinthM - 1.5F, -0.08F}, {x + half + 0.75F, -kPlinthM - 1.0F, 0},
         {Material::kSign, dice->Seed(), dice->Uniformf(0.5, 1.2)}, mesh);
}

void AddBalcony(float x, float floor_y, Dice* dice, Mesh* mesh) {
  const float half = dice->Uniformf(1.2, 1.9);
  const float out = -1.15F;
  const Finish slab = {Material::kPlaster, dice->Seed(), dice->Uniformf(0.6, 1.3)};
  AddBox({x - half, floor_y, out}, {x + half, floor_y + 0.18F, 0}, slab, mesh, true);
  const float rail_y = floor_y - 0.95F;
  if (dice->Chance(0.5)) {
    AddBox({x - half, rail_y, out}, {x + half, floor_y, out + 0.1F},
           {dice->Chance(0.5) ? Material::kPlaster : Material::kWood, dice->Seed(), slab.tone},
           mesh);
    return;
  }
  const Finish bars = {Material::kMetal, dice->Seed(), 0.6F};
  AddBox({x - half, rail_y, out}, {x + half, rail_y + 0.05F, out + 0.05F}, bars, mesh, true);
  for (float at = x - half; at < x + half; at += 0.22F) {
    AddBox({at, rail_y, out}, {at + 0.04F, floor_y, out + 0.04F}, bars, mesh);
  }
}

void AddBay(const HouseStyle& style, float x, const Finish& wall, Dice* dice, Mesh* mesh) {
  const float half = 1.2F;
  const float out = -0.75F;
  const float top = -EavesM(style) + 0.4F;
  AddBox({x - half, top, out}, {x + half, kFoundationM, 0}, wall, mesh);
  AddBox({x - half - 0.1F, top - 0.12F, out - 0.1F}, {x + half + 0.1F, top, 0},
         {Material::kRoofTiles, dice->Seed(), 0.8F}, mesh, true);
  WindowShape shape;
  shape.width = 1.7F;
  shape.height = 1.5F;
  shape.cross = dice->Chance(0.5);
  for (int storey = 0; storey < style.storeys; ++storey) {
    shape.seed = dice->Seed();
    AddWindow(shape, x - shape.width / 2, -kPlinthM - kStoreyM * static_cast<float>(storey) - 2.4F,
              out, mesh);
  }
}

void AddStoreyBands(const HouseStyle& style, Dice* dice, Mesh* mesh) {
  const float half = style.width / 2;
  const Finish stone = {Material::kPlaster, dice->Seed(), dice->Uniformf(0.6, 1.4)};
  const float eaves = -EavesM(style);
  AddBox({-half, eaves, -0.16F}, {half, eaves + 0.22F, 0}, stone, mesh, true);
  if (!dice->Chance(0.4)) return;
  for (int storey = 1; storey < style.storeys; ++storey) {
    const float y = -kPlinthM - kStoreyM * static_cast<float>(storey);
    AddBox({-half, y - 0.1F, -0.09F}, {half, y + 0.1F, 0}, stone, mesh, true);
  }
}

void AddWindows(const HouseStyle& style, const Columns& columns, int door, int bay, Dice* dice,
                Mesh* mesh) {
  WindowShape shape;
  shape.width = std::min(dice->Uniformf(0.9, 1.7), columns.pitch - 0.5F);
  shape.height = dice->Uniformf(1.2, 1.6);
  shape.shutters = columns.pitch - shape.width > 1.0F && dice->Chance(0.4);
  shape.cross = dice->Chance(0.4);
  shape.frame = {Material::kPlaster, dice->Seed(), dice->Chance(0.7) ? 1.5F : 0.4F};
  const int balcony = style.balconies ? dice->Integer(0, columns.count - 1) : -1;
  for (int column = 0; column < columns.count; ++column) {
    if (column == bay) continue;
    for (int storey = 0; storey < style.storeys; ++storey) {
      if (column == door && storey == 0) continue;
      const float floor_y = -kPlinthM - kStoreyM * static_cast<float>(storey);
      WindowShape own = shape;
      own.seed = dice->Seed();
      const float x = columns.Middle(column);
      if (column == balcony && storey > 0) {
        AddBalcony(x, floor_y, dice, mesh);
        own.height = 2.1F;
        own.shutters = false;
        AddWindow(own, x - own.width / 2, floor_y - own.height - 0.1F, 0, mesh);
      } else {
        AddWindow(own, x - own.width / 2, floor_y - own.height - 0.85F, 0, mesh);
      }
    }
  }
}

}  // namespace

void AddWindow(const WindowShape& shape, float x, float y, float z, Mesh* mesh) {
  const float rim = 0.09F;
  const float w = shape.width;
  const float h = shape.height;
  // A window is a frame that stands out and panes set back behind it.
  const auto bar = [&](float left, float up, float right, float low) {
    AddBox({x + left, y + up, z - 0.07F}, {x + right, y + low, z}, shape.frame, mesh, true);
  };
  bar(-rim, -rim, w + rim, 0);
  bar(-rim, 0, 0, h);
  bar(w, 0, w + rim, h);
  const Finish bars = {Material::kMetal, shape.seed, shape.frame.tone * 1.2F};
  mesh->patches.push_back(Rectangle({x, y, z - 0.01F}, {w, 0, 0}, {0, h, 0}, Material::kGlass,
                                    shape.seed,
                                    0.5F + static_cast<float>(shape.seed % 97U) / 80.0F));
  AddQuad({x + w / 2 - 0.04F, y, z - 0.03F}, {x + w / 2 + 0.04F, y, z - 0.03F},
          {x + w / 2 + 0.04F, y + h, z - 0.03F}, {x + w / 2 - 0.04F, y + h, z - 0.03F}, bars, mesh);
  if (shape.cross) {
    AddQuad({x, y + h / 3, z - 0.03F}, {x + w, y + h / 3, z - 0.03F},
            {x + w, y + h / 3 + 0.06F, z - 0.03F}, {x, y + h / 3 + 0.06F, z - 0.03F}, bars, mesh);
  } else if (shape.seed % 4U == 0) {  // This is a blind let down some way.
    const float drop = h * (0.25F + 0.6F * static_cast<float>(shape.seed / 4U % 64U) / 64.0F);
    mesh->patches.push_back(
        Rectangle({x, y, z - 0.05F}, {0, drop, 0}, {w, 0, 0}, Material::kWood, shape.seed, 1.1F));
  }
  AddBox({x - 0.15F, y + h, z - 0.17F}, {x + w + 0.15F, y + h + 0.06F, z},
         {Material::kPavement, shape.seed, 0.9F}, mesh, true);
  if (!shape.shutters) return;
  const float leaf = w * 0.45F;
  for (const float left : {x - rim - leaf, x + w + rim}) {
    AddBox({left, y, z - 0.05F}, {left + leaf, y + h, z},
           {Material::kWood, shape.frame.seed + 5U, 0.7F}, mesh);
  }
}

void AddFront(const HouseStyle& style, const Finish& wall, Dice* dice, Mesh* mesh) {
  const Columns columns = DivideFront(style, dice);
  const int door = dice->Integer(0, columns.count - 1);
  int bay = style.bay ? dice->Integer(0, columns.count - 1) : -1;
  if (bay == door) bay = -1;
  AddDoor(columns.Middle(door), wall, dice, mesh);
  if (bay >= 0) AddBay(style, columns.Middle(bay), wall, dice, mesh);
  AddStoreyBands(style, dice, mesh);
  if (style.windows_in_relief) AddWindows(style, columns, door, bay, dice, mesh);
  // Adds the rain pipe.
  const float side = dice->Chance(0.5) ? 1.0F : -1.0F;
  const float x = side * (style.width / 2 - 0.2F);
  AddBox({x - 0.05F, -EavesM(style), -0.12F}, {x + 0.05F, 0.5F, -0.02F},
         {Material::kMetal, dice->Seed(), dice->Uniformf(0.5, 1.4)}, mesh);
}

}  // namespace corbslam
