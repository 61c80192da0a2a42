#include "services/simulation/worlds/house.h"

#include <algorithm>

#include "services/simulation/worlds/house_parts.h"

namespace corbslam {
namespace {

using Eigen::Vector3f;

// Adds the back and the sides, with painted windows on some.
void AddWalls(const HouseStyle& style, const Finish& wall, Dice* dice, Mesh* mesh) {
  const float half = style.width / 2;
  const float top = -EavesM(style);
  const float height = -top + kFoundationM;
  const Finish painted = {Material::kFacade, dice->Seed(), wall.tone};
  const Finish left = dice->Chance(0.6) ? painted : wall;
  const Finish right = dice->Chance(0.6) ? painted : wall;
  const Vector3f down(0, height, 0);
  mesh->patches.push_back(Rectangle({-half, top, style.depth}, {0, 0, -style.depth}, down,
                                    left.material, left.seed, left.tone));
  mesh->patches.push_back(
      Rectangle({half, top, 0}, {0, 0, style.depth}, down, right.material, right.seed, right.tone));
  mesh->patches.push_back(Rectangle({half, top, style.depth}, {-style.width, 0, 0}, down,
                                    painted.material, painted.seed, painted.tone));
  const Finish front =
      style.windows_in_relief ? wall : Finish{Material::kFacade, dice->Seed(), wall.tone};
  mesh->patches.push_back(Rectangle({-half, top, 0}, {style.width, 0, 0}, down, front.material,
                                    front.seed, front.tone));
  // The plinth stands out a little all round.
  const float out = 0.05F;
  const Finish plinth = {dice->Chance(0.7) ? Material::kPlaster : Material::kPavement, dice->Seed(),
                         0.55F};
  AddBox({-half - out, -kPlinthM * dice->Uniformf(0.6, 1.4), -out},
         {half + out, kFoundationM, style.depth + out}, plinth, mesh);
}

}  // namespace

Mesh BuildHouse(const HouseStyle& style) {
  Mesh mesh;
  Dice dice(style.seed);
  const Finish wall = {style.wall, dice.Seed(), dice.Uniformf(0.75, 1.35)};
  AddWalls(style, wall, &dice, &mesh);
  AddFront(style, wall, &dice, &mesh);
  AddRoof(style, wall, &dice, &mesh);
  return mesh;
}

HouseStyle RandomHouseStyle(uint64_t seed, double width_m, double depth_m) {
  Dice dice(seed);
  HouseStyle style;
  style.width = static_cast<float>(width_m);
  style.depth = static_cast<float>(depth_m);
  style.storeys = dice.Chance(0.12) ? 4 : dice.Integer(1, 3);
  if (style.storeys == 1 && width_m > 14) style.storeys = 2;
  const double roof = dice.Uniform(0, 1);
  style.roof = roof < 0.55   ? RoofKind::kRidgeAlongStreet
               : roof < 0.75 ? RoofKind::kHipped
               : roof < 0.93 ? RoofKind::kGableToStreet
                             : RoofKind::kFlat;
  style.roof_pitch_rad = dice.Uniformf(0.55, 0.85);
  style.wall = dice.Chance(0.82) ? Material::kPlaster : Material::kBrick;
  style.windows_in_relief = dice.Chance(0.75);
  style.balconies = dice.Chance(0.35);
  style.bay = !style.balconies && dice.Chance(0.25);
  style.dormers = dice.Chance(0.5);
  style.seed = dice.Next();
  return style;
}

}  // namespace corbslam
