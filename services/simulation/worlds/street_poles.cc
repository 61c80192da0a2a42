// Puts up lamp posts, signs, bins, cabinets and bollards.
#include "services/simulation/worlds/mesh_shapes.h"
#include "services/simulation/worlds/street_site.h"

namespace corbslam {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;

constexpr double kPoleMiddleM = 4.95;
constexpr double kPoleClearanceM = 2.6;

// Things that stand at the kerb; z of a mesh points away from the road.
struct KerbThings {
  uint32_t lamp = 0;
  std::vector<uint32_t> signs;
  std::vector<uint32_t> boxes;
  uint32_t bollard = 0;
};

Mesh MakeLamp() {
  Mesh mesh;
  const Finish metal = {Material::kMetal, 1, 1};
  AddTube({0, 0.2F, 0}, {0, -1.1F, 0}, 0.1F, 0.1F, 6, metal, &mesh);
  AddTube({0, -1.1F, 0}, {0, -6.6F, 0}, 0.07F, 0.05F, 6, metal, &mesh);
  AddTube({0, -6.6F, 0}, {0, -7.0F, -1.3F}, 0.045F, 0.04F, 4, metal, &mesh);
  AddBox({-0.12F, -7.15F, -1.9F}, {0.12F, -6.98F, -1.2F}, {Material::kMetal, 2, 1.4F}, &mesh, true);
  return mesh;
}

// The kinds are 0: round, 1: triangle, 2: rectangle, 3: two shields, 4: street name.
Mesh MakeSign(int kind, uint32_t seed) {
  Mesh mesh;
  const Finish metal = {Material::kMetal, seed, 1.1F};
  const Finish print = {Material::kSign, seed, 1.3F};
  AddTube({0, 0.2F, 0}, {0, -2.9F, 0}, 0.035F, 0.035F, 5, metal, &mesh);
  // Shields face those who come along the road: they stand across x, a little before the pole.
  const float x = -0.05F;
  switch (kind) {
    case 0:
    case 3:
      AddDisc({x, -2.55F, 0}, Vector3f::UnitX(), 0.32F, print, &mesh);
      AddDisc({x - 0.005F, -2.55F, 0}, Vector3f::UnitX(), 0.22F, {Material::kSign, seed + 1, 0.5F},
              &mesh);
      if (kind == 3) {
        AddQuad({x, -2.15F, -0.3F}, {x, -2.15F, 0.3F}, {x, -1.85F, 0.3F}, {x, -1.85F, -0.3F}, print,
                &mesh);
      }
      break;
    case 1:
      AddQuad({x, -2.85F, 0}, {x, -2.2F, 0.38F}, {x, -2.2F, -0.38F}, {x, -2.2F, -0.38F}, print,
              &mesh);
      break;
    case 2:
      AddQuad({x, -2.9F, -0.3F}, {x, -2.9F, 0.3F}, {x, -2.05F, 0.3F}, {x, -2.05F, -0.3F}, print,
              &mesh);
      break;
    default:
      AddBox({-0.02F, -2.9F, -0.6F}, {0.02F, -2.7F, 0.6F}, print, &mesh, true);
      AddBox({-0.55F, -2.65F, -0.02F}, {0.55F, -2.45F, 0.02F}, print, &mesh, true);
  }
  return mesh;
}

Mesh MakeBox(int kind, uint32_t seed) {
  Mesh mesh;
  switch (kind) {
    case 0:  // An electricity cabinet.
      AddBox({-0.45F, -1.15F, -0.18F}, {0.45F, 0.2F, 0.18F}, {Material::kDoor, seed, 1}, &mesh);
      AddBox({-0.48F, -1.2F, -0.22F}, {0.48F, -1.15F, 0.22F}, {Material::kMetal, seed, 1}, &mesh);
      break;
    case 1:  // Two bins.
      for (const float x : {-0.33F, 0.33F}) {
        AddBox({x - 0.29F, -1.0F, -0.3F}, {x + 0.29F, 0, 0.3F},
               {Material::kCarPaint, seed + (x > 0 ? 1U : 0U), 0.7F}, &mesh);
        AddBox({x - 0.31F, -1.08F, -0.34F}, {x + 0.31F, -1.0F, 0.34F}, {Material::kTyre, seed, 1},
               &mesh);
      }
      break;
    default:  // A poster column's small sister: a board with two posters.
      AddBox({-0.65F, -2.2F, -0.05F}, {0.65F, -0.5F, 0.05F}, {Material::kSign, seed, 1.1F}, &mesh,
             true);
      for (const float x : {-0.6F, 0.6F}) {
        AddBox({x - 0.04F, -2.3F, -0.06F}, {x + 0.04F, 0.2F, 0.06F}, {Material::kMetal, seed, 0.7F},
               &mesh);
      }
  }
  return mesh;
}

Mesh MakeBollard() {
  Mesh mesh;
  AddTube({0, 0.1F, 0}, {0, -0.9F, 0}, 0.06F, 0.06F, 6, {Material::kMetal, 3, 0.9F}, &mesh);
  AddTube({0, -0.82F, 0}, {0, -0.7F, 0}, 0.065F, 0.065F, 6, {Material::kRoadMarking, 3, 1}, &mesh);
  AddDisc({0, -0.9F, 0}, -Vector3f::UnitY(), 0.06F, {Material::kMetal, 3, 0.7F}, &mesh);
  return mesh;
}

KerbThings AddPrototypes(StreetSite* site) {
  KerbThings things;
  Dice dice = site->DiceFor(StreetDice::kPrototypes, 3);
  things.lamp = site->AddMesh(MakeLamp());
  for (int kind = 0; kind < 5; ++kind) {
    things.signs.push_back(site->AddMesh(MakeSign(kind, dice.Seed())));
  }
  for (int kind = 0; kind < 3; ++kind) {
    things.boxes.push_back(site->AddMesh(MakeBox(kind, dice.Seed())));
  }
  things.bollard = site->AddMesh(MakeBollard());
  return things;
}

bool StandAt(uint32_t mesh, const Station& station, int side, double middle_m, double half_m,
             Dice* dice, StreetSite* site) {
  const Vector2d at = Beside(station, LateralOf(side, middle_m));
  if (site->ground.MiddleDistance(at) < middle_m - 0.3) return false;
  const Vector2d away = side * station.Right();
  if (!site->footprints.Take({at, away, half_m, half_m}, kPoleClearanceM)) return false;
  site->Place(mesh, at, away, 1, dice->Seed());
  return true;
}

void PutUpAt(const KerbThings& things, const Station& station, int64_t number, StreetSite* site) {
  Dice dice = site->DiceFor(StreetDice::kPole, site->Kind(number), 1);
  const int side = dice.Chance(0.6) ? 1 : -1;
  const double what = dice.Uniform(0, 1);
  if (what < 0.5) {
    StandAt(things.signs[static_cast<size_t>(dice.Integer(0, 4))], station, side, kPoleMiddleM, 0.1,
            &dice, site);
  } else if (what < 0.8) {
    StandAt(things.boxes[static_cast<size_t>(dice.Integer(0, 2))], station, side, 6.1, 0.5, &dice,
            site);
  }
}

}  // namespace

void PutUpPoles(StreetSite* site) {
  const KerbThings things = AddPrototypes(site);
  const std::vector<Station>& stations = site->path.stations();
  const size_t lamps = 56;  // Number of stations between two lamps.
  const size_t others = 17;
  const size_t bollards = 3;
  for (size_t i = 0; i < stations.size(); ++i) {
    const Station& station = stations[i];
    if (station.again) continue;
    const auto number = static_cast<int64_t>(i);
    if (i % lamps == 10) {
      Dice dice = site->DiceFor(StreetDice::kPole, number, 2);
      StandAt(things.lamp, station, i / lamps % 2 == 0 ? 1 : -1, kPoleMiddleM, 0.12, &dice, site);
    }
    if (i % others == 0) PutUpAt(things, station, number / static_cast<int64_t>(others), site);
    const bool row = site->DiceFor(StreetDice::kPole, number / 48, 3).Chance(0.12);
    if (row && i % bollards == 0) {
      Dice dice = site->DiceFor(StreetDice::kPole, number, 4);
      StandAt(things.bollard, station, 1, 4.6, 0.1, &dice, site);
    }
  }
}

}  // namespace corbslam
