// Parks cars.
#include "services/simulation/worlds/cars.h"
#include "services/simulation/worlds/street_site.h"

namespace corbslam {
namespace {

using Eigen::Vector2d;

// Least distance from a car's side to any station: half of one's own car and then some.
constexpr double kCarClearanceM = 1.85;

struct CarMeshes {
  std::vector<CarPrototype> prototypes;
  uint32_t first = 0;
};

bool Park(const CarMeshes& cars, const Vector2d& at, const Vector2d& ahead, Dice* dice,
          StreetSite* site) {
  const int which = dice->Integer(0, static_cast<int>(cars.prototypes.size()) - 1);
  const CarPrototype& car = cars.prototypes[static_cast<size_t>(which)];
  const Footprint footprint = {at, ahead, static_cast<double>(car.length) / 2 + 0.15,
                               static_cast<double>(car.width) / 2 + 0.12};
  if (!site->footprints.Take(footprint, kCarClearanceM)) return false;
  Instance instance;
  instance.mesh = cars.first + static_cast<uint32_t>(which);
  instance.world_from_mesh = Similarity3d::FromRigid(OnRoad(site->ground, at, ahead));
  // Cars stand on the pavement with two wheels or four.
  if (site->ground.MiddleDistance(at) > StreetProfile::kKerb) {
    instance.world_from_mesh.translation.y() -= StreetProfile::kKerbHeight;
  }
  instance.seed = dice->Seed();
  site->scene.instances.push_back(instance);
  return true;
}

// Returns the way to the next place.
double TryPlace(const CarMeshes& cars, const Station& station, int side, int64_t number,
                StreetSite* site) {
  const StreetBlock block = BlockAt(*site, station);
  Dice dice = site->DiceFor(StreetDice::kCar, site->Kind(number), side);
  const bool bay = side < 0 && block.bays_left;
  const double share = side > 0 ? block.parked_right : block.parked_left;
  const double next = bay ? dice.Uniform(2.7, 3.2) : dice.Uniform(5.2, 6.6);
  if (!dice.Chance(share)) return next;
  const double middle = bay ? 6.9 : 3.95 + dice.Uniform(-0.1, 0.25);
  const Vector2d at = Beside(station, LateralOf(side, middle));
  const double found = site->ground.MiddleDistance(at);
  if (found < middle - 0.5) return 1;  // This is a crossing's mouth.
  const double turn = dice.Uniform(-0.03, 0.03);
  const Vector2d along = station.ahead + turn * station.Right();
  const bool turned = dice.Chance(side > 0 ? 0.1 : 0.75);
  const Vector2d across = (dice.Chance(0.7) ? -1 : 1) * (station.Right() + turn * station.ahead);
  const Vector2d ahead = bay ? across : (turned ? -1 : 1) * along;
  return Park(cars, at, ahead.normalized(), &dice, site) ? next : 1;
}

}  // namespace

void ParkCars(StreetSite* site) {
  CarMeshes cars;
  Dice dice = site->DiceFor(StreetDice::kPrototypes, 1);
  cars.prototypes = BuildCarPrototypes(dice.Next());
  cars.first = static_cast<uint32_t>(site->scene.meshes.size());
  for (const CarPrototype& car : cars.prototypes) site->AddMesh(car.mesh);
  for (const int side : {1, -1}) {
    int64_t number = 0;
    double way = 0;
    for (const Station& station : site->path.stations()) {
      way -= StreetPath::kStepM;
      if (way > 0 || station.again) continue;
      way = TryPlace(cars, station, side, number++, site);
    }
  }
}

}  // namespace corbslam
