#include <algorithm>
#include <cmath>

#include "services/simulation/worlds/house_parts.h"

namespace corbslam {
namespace {

using Eigen::Vector3f;

constexpr float kOverhangM = 0.45F;

// The roof over the rectangle of walls with its edges, y of the eaves and of the ridge.
struct RoofShape {
  float left;
  float right;
  float front;
  float back;
  float eaves;
  float ridge;
};

void AddSaddle(const RoofShape& at, bool along_street, const Finish& tiles, const Finish& wall,
               Mesh* mesh) {
  const float middle_x = (at.left + at.right) / 2;
  const float middle_z = (at.front + at.back) / 2;
  const float over = kOverhangM;
  const Vector3f down(0, 0.3F, 0);  // What the overhang hangs below the eaves.
  if (along_street) {
    const Vector3f left(at.left - over, at.ridge, middle_z);
    const Vector3f right(at.right + over, at.ridge, middle_z);
    for (const float edge : {at.front - over, at.back + over}) {
      const Vector3f low_left = Vector3f(left.x(), at.eaves, edge) + down;
      const Vector3f low_right = Vector3f(right.x(), at.eaves, edge) + down;
      AddQuad(left, right, low_right, low_left, tiles, mesh);
    }
    for (const float x : {at.left, at.right}) {
      const Vector3f top(x, at.ridge, middle_z);
      AddQuad({x, at.eaves, at.front}, {x, at.eaves, at.back}, top, top, wall, mesh);
    }
    return;
  }
  const Vector3f front(middle_x, at.ridge, at.front - over);
  const Vector3f back(middle_x, at.ridge, at.back + over);
  for (const float edge : {at.left - over, at.right + over}) {
    AddQuad(back, front, Vector3f(edge, at.eaves, front.z()) + down,
            Vector3f(edge, at.eaves, back.z()) + down, tiles, mesh);
  }
  for (const float z : {at.front, at.back}) {
    const Vector3f top(middle_x, at.ridge, z);
    AddQuad({at.left, at.eaves, z}, {at.right, at.eaves, z}, top, top, wall, mesh);
  }
}

void AddHipped(const RoofShape& at, const Finish& tiles, Mesh* mesh) {
  const float over = kOverhangM;
  const float half_depth = (at.back - at.front) / 2;
  const float inset = std::min(half_depth, (at.right - at.left) / 2 - 0.3F);
  const float middle_z = at.front + half_depth;
  const float low = at.eaves + 0.3F;
  const Vector3f left(at.left + inset, at.ridge, middle_z);
  const Vector3f right(at.right - inset, at.ridge, middle_z);
  const Vector3f front_left(at.left - over, low, at.front - over);
  const Vector3f front_right(at.right + over, low, at.front - over);
  const Vector3f back_left(at.left - over, low, at.back + over);
  const Vector3f back_right(at.right + over, low, at.back + over);
  AddQuad(left, right, front_right, front_left, tiles, mesh);
  AddQuad(right, left, back_left, back_right, tiles, mesh);
  AddQuad(front_left, back_left, left, left, tiles, mesh);
  AddQuad(back_right, front_right, right, right, tiles, mesh);
}

void AddFlat(const RoofShape& at, Dice* dice, Mesh* mesh) {
  AddBox({at.left - 0.2F, at.eaves - 0.4F, at.front - 0.2F},
         {at.right + 0.2F, at.eaves, at.back + 0.2F},
         {Material::kMetal, dice->Seed(), dice->Uniformf(0.6, 1.4)}, mesh, true);
}

void AddChimneys(const HouseStyle& style, const RoofShape& at, Dice* dice, Mesh* mesh) {
  const int count = dice->Integer(1, 3);
  for (int i = 0; i < count; ++i) {
    const float x = dice->Uniformf(-0.4, 0.4) * style.width;
    const float z = (at.front + at.back) / 2 + dice->Uniformf(-0.8, 0.8);
    const float half = dice->Uniformf(0.25, 0.5);
    const float top = at.ridge - dice->Uniformf(0.5, 1.1);
    AddBox({x - half, top, z - half}, {x + half, at.ridge + 1.2F, z + half},
           {dice->Chance(0.6) ? Material::kBrick : Material::kPlaster, dice->Seed(), 0.9F}, mesh);
  }
  if (dice->Chance(0.5)) {  // This is an aerial.
    const float x = dice->Uniformf(-0.3, 0.3) * style.width;
    const float z = (at.front + at.back) / 2;
    const Finish metal = {Material::kMetal, dice->Seed(), 0.5F};
    AddTube({x, at.ridge - 2.2F, z}, {x, at.ridge, z}, 0.035F, 0.035F, 3, metal, mesh);
    AddTube({x - 0.5F, at.ridge - 2.0F, z}, {x + 0.5F, at.ridge - 2.0F, z}, 0.025F, 0.025F, 3,
            metal, mesh);
  }
}

// Adds dormers to the front slope.
void AddDormers(const HouseStyle& style, const RoofShape& at, const Finish& tiles, Dice* dice,
                Mesh* mesh) {
  const int count = std::max(1, static_cast<int>(style.width / dice->Uniformf(3.2, 5.5)));
  const float pitch = style.width / static_cast<float>(count);
  const float run = (at.back - at.front) / 2;
  const float rise = at.eaves - at.ridge;
  const float half = 0.75F;
  const float height = std::min(1.5F, 0.55F * rise);
  const float low_share = 0.12F;
  const float y_low = at.eaves - low_share * rise;
  const float y_top = y_low - height;
  const float z_front = at.front + low_share * run;
  const float z_back = at.front + (at.eaves - y_top) / rise * run;
  const Finish side = {Material::kPlaster, dice->Seed(), dice->Uniformf(0.6, 1.3)};
  for (int i = 0; i < count; ++i) {
    const float x = at.left + pitch * (static_cast<float>(i) + 0.5F);
    AddBox({x - half, y_top, z_front}, {x + half, y_low + 0.3F, z_back}, side, mesh);
    AddBox({x - half - 0.15F, y_top - 0.12F, z_front - 0.25F}, {x + half + 0.15F, y_top, z_back},
           tiles, mesh, true);
    WindowShape window;
    window.width = 1.0F;
    window.height = height - 0.45F;
    window.seed = dice->Seed();
    AddWindow(window, x - 0.5F, y_top + 0.2F, z_front, mesh);
  }
}

void AddSkylights(const HouseStyle& style, const RoofShape& at, Dice* dice, Mesh* mesh) {
  const float run = (at.back - at.front) / 2;
  const float rise = at.eaves - at.ridge;
  const Vector3f slope = Vector3f(0, -rise, run).normalized();
  const Vector3f out = Vector3f(0, -run, -rise).normalized();
  const int count = dice->Integer(0, 3);
  for (int i = 0; i < count; ++i) {
    const float share = dice->Uniformf(0.3, 0.6);
    const Vector3f corner(dice->Uniformf(-0.4, 0.35) * style.width, at.eaves - share * rise,
                          at.front + share * run);
    const Vector3f start = corner + 0.06F * out;
    mesh->patches.push_back(
        Rectangle(start, {0.9F, 0, 0}, 1.2F * slope, Material::kMetal, dice->Seed(), 0.6F));
    const float tone = dice->Uniformf(0.8, 1.5);
    mesh->patches.push_back(Rectangle(start + Vector3f(0.1F, 0, 0) + 0.1F * slope + 0.02F * out,
                                      {0.7F, 0, 0}, 1.0F * slope, Material::kGlass, dice->Seed(),
                                      tone));
  }
}

}  // namespace

void AddRoof(const HouseStyle& style, const Finish& wall, Dice* dice, Mesh* mesh) {
  const Finish tiles = {Material::kRoofTiles, dice->Seed(), dice->Uniformf(0.6, 1.3)};
  const bool to_street = style.roof == RoofKind::kGableToStreet;
  const float run = (to_street ? style.width : style.depth) / 2;
  const float rise = run * std::tan(style.roof_pitch_rad);
  const float eaves = -EavesM(style);
  const RoofShape at = {.left = -style.width / 2,
                        .right = style.width / 2,
                        .front = 0,
                        .back = style.depth,
                        .eaves = eaves,
                        .ridge = eaves - rise};
  if (style.roof == RoofKind::kFlat) {
    AddFlat(at, dice, mesh);
    return;
  }
  if (style.roof == RoofKind::kHipped) {
    AddHipped(at, tiles, mesh);
  } else {
    AddSaddle(at, !to_street, tiles, wall, mesh);
  }
  AddChimneys(style, at, dice, mesh);
  AddBox({at.left, eaves + 0.18F, -kOverhangM - 0.1F},
         {at.right, eaves + 0.32F, -kOverhangM + 0.05F}, {Material::kMetal, dice->Seed(), 0.8F},
         mesh, true);
  if (to_street) return;
  if (style.dormers && style.roof == RoofKind::kRidgeAlongStreet) {
    AddDormers(style, at, tiles, dice, mesh);
  } else {
    AddSkylights(style, at, dice, mesh);
  }
}

}  // namespace corbslam
