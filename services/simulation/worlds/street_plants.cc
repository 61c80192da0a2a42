// Plants street trees, garden trees and bushes.
#include <numbers>

#include "services/simulation/worlds/plants.h"
#include "services/simulation/worlds/street_site.h"

namespace corbslam {
namespace {

using Eigen::Vector2d;

constexpr double kStreetTreeMiddleM = 5.45;  // Street trees stand beyond the parked cars.

// Meshes of the scene.
struct TreeMeshes {
  std::vector<uint32_t> street;
  std::vector<uint32_t> garden;
  std::vector<uint32_t> bushes;
};

TreeMeshes AddPrototypes(StreetSite* site) {
  Dice dice = site->DiceFor(StreetDice::kPrototypes, 2);
  TreePrototypes prototypes = BuildTreePrototypes(dice.Next());
  TreeMeshes trees;
  for (Mesh& mesh : prototypes.street) trees.street.push_back(site->AddMesh(std::move(mesh)));
  for (Mesh& mesh : prototypes.garden) trees.garden.push_back(site->AddMesh(std::move(mesh)));
  for (Mesh& mesh : prototypes.bushes) trees.bushes.push_back(site->AddMesh(std::move(mesh)));
  return trees;
}

bool PlantOne(const std::vector<uint32_t>& sorts, const Vector2d& at, double half_m,
              double clearance_m, double scale, Dice* dice, StreetSite* site) {
  const double angle = dice->Uniform(0, 2 * std::numbers::pi);
  const Vector2d ahead(std::cos(angle), std::sin(angle));
  if (!site->footprints.Take({at, ahead, half_m, half_m}, clearance_m)) return false;
  const int sort = dice->Integer(0, static_cast<int>(sorts.size()) - 1);
  site->Place(sorts[static_cast<size_t>(sort)], at, ahead, scale, dice->Seed());
  return true;
}

void PlantStreet(const TreeMeshes& trees, StreetSite* site) {
  for (const int side : {1, -1}) {
    double way = 3;
    int64_t number = 0;
    for (const Station& station : site->path.stations()) {
      way -= StreetPath::kStepM;
      if (way > 0 || station.again) continue;
      const StreetBlock block = BlockAt(*site, station);
      Dice dice = site->DiceFor(StreetDice::kTree, site->Kind(number++), side);
      const Vector2d at = Beside(station, LateralOf(side, kStreetTreeMiddleM));
      const bool mouth = site->ground.MiddleDistance(at) < kStreetTreeMiddleM - 0.4;
      const bool planted =
          !mouth && dice.Chance(0.85) &&
          PlantOne(trees.street, at, 0.25, 3.2, dice.Uniform(0.85, 1.2), &dice, site);
      way = planted ? block.tree_spacing_m * dice.Uniform(0.85, 1.2) : 1.5;
    }
  }
}

// The room that is left on both sides gets trees and bushes, tried at random places.
void PlantGardens(const TreeMeshes& trees, StreetSite* site) {
  const std::vector<Station>& stations = site->path.stations();
  for (size_t i = 0; i < stations.size(); i += 2) {
    if (stations[i].again) continue;
    Dice dice =
        site->DiceFor(StreetDice::kGarden, site->options.look_alike ? static_cast<int64_t>(i % 128)
                                                                    : static_cast<int64_t>(i));
    for (const int side : {1, -1}) {
      const bool bush = dice.Chance(0.6);
      const double middle = bush ? dice.Uniform(7.3, 14) : dice.Uniform(8.5, 34);
      const Vector2d at = Beside(stations[i], LateralOf(side, middle));
      if (site->ground.MiddleDistance(at) < 7.2) continue;
      if (bush) {
        PlantOne(trees.bushes, at, 0.55, 5.8, dice.Uniform(0.6, 1.4), &dice, site);
      } else if (dice.Chance(0.45)) {
        PlantOne(trees.garden, at, 1.1, 7.2, dice.Uniform(0.75, 1.3), &dice, site);
      }
    }
  }
}

}  // namespace

void PlantTrees(StreetSite* site) {
  const TreeMeshes trees = AddPrototypes(site);
  PlantStreet(trees, site);
  PlantGardens(trees, site);
}

}  // namespace corbslam
