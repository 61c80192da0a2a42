// Builds houses along the street, garages between them, and a row behind.
#include <algorithm>
#include <cmath>

#include "services/simulation/worlds/house.h"
#include "services/simulation/worlds/mesh_shapes.h"
#include "services/simulation/worlds/street_site.h"

namespace corbslam {
namespace {

using Eigen::Vector2d;

// Where a house would stand.
struct Lot {
  Vector2d front;  // Middle of the front.
  Vector2d away;   // Unit vector away from the street.
  double width = 10;
  double depth = 10;
};

Footprint FootprintOf(const Lot& lot) {
  return {lot.front + lot.depth / 2 * lot.away, lot.away, lot.depth / 2, lot.width / 2};
}

// Returns the last station of the same stretch within `length_m` after `first`; `first` if it ends
// before.
size_t StretchEnd(const std::vector<Station>& stations, size_t first, double length_m) {
  const size_t last = first + static_cast<size_t>(std::ceil(length_m / StreetPath::kStepM));
  if (last >= stations.size()) return first;
  const double straight = (stations[last].at - stations[first].at).norm();
  return stations[last].driven == stations[first].driven && straight > 0.5 * length_m ? last
                                                                                      : first;
}

bool LayOut(const std::vector<Station>& stations, size_t first, int side, double setback_m,
            Lot* lot) {
  const size_t last = StretchEnd(stations, first, lot->width);
  if (last == first) return false;
  const Vector2d from = stations[first].at;
  const Vector2d to = stations[last].at;
  const Vector2d along = (to - from).normalized();
  lot->away = side * Vector2d(along.y(), -along.x());
  lot->front = (from + to) / 2 + setback_m * lot->away;
  return true;
}

// A slope runs under the house: its origin is at the highest place of the front.
Eigen::Vector3d Origin(const StreetSite& site, const Lot& lot) {
  const Vector2d along(lot.away.y(), -lot.away.x());
  Eigen::Vector3d origin = site.Foot(lot.front);
  for (const double share : {-0.5, 0.5}) {
    origin.y() = std::min(origin.y(), site.Foot(lot.front + share * lot.width * along).y());
  }
  return origin;
}

void BuildOn(const Lot& lot, uint64_t seed, bool plain, StreetSite* site) {
  HouseStyle style = RandomHouseStyle(seed, lot.width, lot.depth);
  if (plain) {
    style.windows_in_relief = false;
    style.balconies = style.bay = style.dormers = false;
    style.storeys = std::max(style.storeys, 3);
  }
  site->Build(BuildHouse(style), Origin(*site, lot), lot.away);
}

constexpr double kHouseClearanceM = 6.4;

// Tries the lot wide, then narrower, then further back. Returns the way to go on from there.
double TryHouse(size_t first, int side, int64_t number, StreetSite* site) {
  const std::vector<Station>& stations = site->path.stations();
  const StreetBlock block = BlockAt(*site, stations[first]);
  Dice dice = site->DiceFor(StreetDice::kHouse, site->Kind(number), side);
  const double width = dice.Uniform(block.width_low_m, block.width_high_m);
  const double depth = dice.Uniform(8.5, 12);
  // The left pavement lies further from the path; bays take more room.
  const double left =
      side < 0 ? 2 * StreetProfile::kMiddleLeftOfPath + (block.bays_left ? 3 : 0) : 0;
  const double setback = block.setback_m + left + dice.Uniform(-0.4, 0.9);
  const double gap = dice.Uniform(block.gap_low_m, block.gap_high_m);
  const uint64_t seed = dice.Next();
  for (const double shrink : {1.0, 0.8, 0.62}) {
    for (const double back : {0.0, 3.0}) {
      Lot lot;
      lot.width = std::max(7.0, shrink * width);
      lot.depth = depth;
      if (!LayOut(stations, first, side, setback + back, &lot)) continue;
      if (!site->footprints.Take(FootprintOf(lot), kHouseClearanceM)) continue;
      BuildOn(lot, seed, false, site);
      return lot.width + gap;
    }
  }
  return 2;
}

}  // namespace

void BuildFrontHouses(StreetSite* site) {
  const std::vector<Station>& stations = site->path.stations();
  for (const int side : {1, -1}) {
    int64_t number = 0;
    double way = 0;
    for (size_t i = 0; i < stations.size(); ++i) {
      way -= StreetPath::kStepM;
      if (way > 0 || stations[i].again) continue;
      way = TryHouse(i, side, number++, site);
    }
  }
}

void BuildGarages(StreetSite* site) {
  const std::vector<Station>& stations = site->path.stations();
  for (size_t i = 0; i < stations.size(); i += 10) {
    if (stations[i].again) continue;
    Dice dice = site->DiceFor(StreetDice::kGarage, static_cast<int64_t>(i));
    const int side = dice.Chance(0.5) ? 1 : -1;
    Lot lot;
    lot.width = dice.Chance(0.7) ? 3.2 : 6.2;
    lot.depth = 6;
    const double setback = LateralOf(side, dice.Uniform(8.5, 13));
    if (!LayOut(stations, i, side, std::abs(setback), &lot)) continue;
    if (!site->footprints.Take(FootprintOf(lot), kHouseClearanceM)) continue;
    Mesh mesh;
    const auto half = static_cast<float>(lot.width / 2);
    const auto depth = static_cast<float>(lot.depth);
    AddBox({-half, -2.5F, 0}, {half, 1.5F, depth},
           {Material::kPlaster, dice.Seed(), dice.Uniformf(0.8, 1.4)}, &mesh);
    AddBox({-half - 0.1F, -2.75F, -0.25F}, {half + 0.1F, -2.5F, depth + 0.1F},
           {Material::kMetal, dice.Seed(), dice.Uniformf(0.6, 1.5)}, &mesh, true);
    for (float x = -half + 0.3F; x + 2.4F < half + 0.1F; x += 3.0F) {
      const float tone = dice.Uniformf(0.5, 1.2);
      const uint32_t seed = dice.Seed();
      mesh.patches.push_back(Rectangle({x, -2.2F, -0.02F}, {2.5F, 0, 0}, {0, 2.2F, 0},
                                       dice.Chance(0.5) ? Material::kWood : Material::kDoor, seed,
                                       tone));
    }
    site->Build(mesh, Origin(*site, lot), lot.away);
  }
}

void BuildBackHouses(StreetSite* site) {
  const std::vector<Station>& stations = site->path.stations();
  for (const int side : {1, -1}) {
    for (size_t i = 0; i < stations.size(); i += 12) {
      if (stations[i].again) continue;
      Dice dice = site->DiceFor(StreetDice::kBackHouse, static_cast<int64_t>(i), side);
      Lot lot;
      lot.width = dice.Uniform(11, 24);
      lot.depth = dice.Uniform(9, 12);
      const double setback = dice.Uniform(27, 42);
      if (!LayOut(stations, i, side, setback, &lot)) continue;
      if (!site->footprints.Take(FootprintOf(lot), 2 * kHouseClearanceM)) continue;
      BuildOn(lot, dice.Next(), true, site);
    }
  }
}

}  // namespace corbslam
