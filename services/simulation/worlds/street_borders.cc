// Builds what divides the front gardens from the pavement and from each other: hedges, walls and
// fences.
#include <algorithm>

#include "services/simulation/worlds/mesh_shapes.h"
#include "services/simulation/worlds/plants.h"
#include "services/simulation/worlds/street_site.h"

namespace corbslam {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;

constexpr double kBorderMiddleM = 6.95;
constexpr double kThicknessM = 0.6;

enum class BorderKind { kHedge, kWall, kWallWithBars, kPlanks };

void AddBars(float length, float low, float high, uint32_t seed, Mesh* mesh) {
  const Finish metal = {Material::kMetal, seed, 0.6F};
  AddBox({0, high, -0.02F}, {length, high + 0.05F, 0.02F}, metal, mesh);
  for (float x = 0.05F; x < length; x += 0.16F) {
    AddQuad({x, high, 0}, {x + 0.03F, high, 0}, {x + 0.03F, low, 0}, {x, low, 0}, metal, mesh);
  }
}

Mesh MakeBorder(BorderKind kind, double length_m, Dice* dice) {
  Mesh mesh;
  const auto length = static_cast<float>(length_m);
  const uint32_t seed = dice->Seed();
  const float tone = dice->Uniformf(0.6, 1.3);
  const Material stone = dice->Chance(0.6)   ? Material::kPlaster
                         : dice->Chance(0.5) ? Material::kBrick
                                             : Material::kPavement;
  switch (kind) {
    case BorderKind::kHedge: {
      const float thickness = dice->Uniformf(0.5, 0.8);
      return BuildHedge(length, dice->Uniformf(0.8, 1.7), thickness, seed);
    }
    case BorderKind::kWall: {
      const float height = dice->Uniformf(0.5, 1.3);
      AddBox({0, -height, -0.12F}, {length, 0.6F, 0.12F}, {stone, seed, tone}, &mesh);
      AddBox({0, -height - 0.06F, -0.16F}, {length, -height, 0.16F},
             {Material::kPavement, seed, 1.1F}, &mesh);
      break;
    }
    case BorderKind::kWallWithBars:
      AddBox({0, -0.4F, -0.12F}, {length, 0.6F, 0.12F}, {stone, seed, tone}, &mesh);
      AddBars(length, -0.4F, -1.2F, seed, &mesh);
      break;
    case BorderKind::kPlanks: {
      const float height = dice->Uniformf(0.8, 1.8);
      AddBox({0, -height, -0.03F}, {length, 0.2F, 0.03F}, {Material::kWood, seed, tone}, &mesh);
      break;
    }
  }
  for (const float x : {0.0F, length - 0.3F}) {
    if (kind == BorderKind::kPlanks || !dice->Chance(0.6)) continue;
    AddBox({x, -1.35F, -0.17F}, {x + 0.3F, 0.6F, 0.17F}, {stone, seed + 1, tone}, &mesh);
  }
  return mesh;
}

BorderKind KindOf(Dice* dice) {
  const double kind = dice->Uniform(0, 1);
  return kind < 0.5    ? BorderKind::kHedge
         : kind < 0.72 ? BorderKind::kWall
         : kind < 0.86 ? BorderKind::kWallWithBars
                       : BorderKind::kPlanks;
}

// Puts a border up from one place to another, along x of the mesh. False if something is in the
// way.
bool PutUp(const Vector2d& from, const Vector2d& to, BorderKind kind, Dice* dice,
           StreetSite* site) {
  const double length = (to - from).norm();
  if (length < 1) return false;
  const Vector2d along = (to - from) / length;
  const Footprint footprint = {(from + to) / 2, along, length / 2, kThicknessM / 2};
  if (!site->footprints.Take(footprint, 5.4)) return false;
  Eigen::Vector3d foot = site->Foot(from);
  foot.y() = std::max(foot.y(), site->Foot(to).y());
  site->Build(MakeBorder(kind, length, dice), foot, {-along.y(), along.x()});
  return true;
}

void AlongPavement(int side, StreetSite* site) {
  const std::vector<Station>& stations = site->path.stations();
  double way = 2;
  int64_t number = 0;
  for (size_t i = 0; i < stations.size(); ++i) {
    way -= StreetPath::kStepM;
    if (way > 0 || stations[i].again) continue;
    Dice dice = site->DiceFor(StreetDice::kBorder, site->Kind(number++), side);
    const double length = dice.Uniform(3.5, 8);
    const size_t last = i + static_cast<size_t>(length / StreetPath::kStepM);
    if (last >= stations.size() || stations[last].driven != stations[i].driven) continue;
    way = length + (dice.Chance(0.7) ? 0.05 : dice.Uniform(1.2, 4));  // A larger gap is a gate.
    const StreetBlock block = BlockAt(*site, stations[i]);
    if (!dice.Chance(block.border)) continue;
    const double bays = side < 0 && block.bays_left ? 2.9 : 0;
    const double lateral = LateralOf(side, kBorderMiddleM + bays);
    if (!PutUp(Beside(stations[i], lateral), Beside(stations[last], lateral), KindOf(&dice), &dice,
               site)) {
      way = 1;
    }
  }
}

// Closes the gaps between houses, further back, so that they don't open onto nothing.
void BehindGardens(int side, StreetSite* site) {
  const std::vector<Station>& stations = site->path.stations();
  for (size_t i = 0; i + 8 < stations.size(); i += 8) {
    if (stations[i].again || stations[i].driven != stations[i + 8].driven) continue;
    Dice dice = site->DiceFor(StreetDice::kBorder, static_cast<int64_t>(i), side * 2);
    const double lateral = LateralOf(side, dice.Uniform(14, 24));
    const BorderKind kind = dice.Chance(0.6) ? BorderKind::kHedge : BorderKind::kPlanks;
    PutUp(Beside(stations[i], lateral), Beside(stations[i + 8], lateral), kind, &dice, site);
  }
}

}  // namespace

void BuildBorders(StreetSite* site) {
  for (const int side : {1, -1}) {
    AlongPavement(side, site);
    BehindGardens(side, site);
  }
}

}  // namespace corbslam
