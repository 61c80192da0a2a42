// Lays what lies on the carriageway: lines, zebra crossings, manholes, mended places and seams of
// tar.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "services/simulation/worlds/mesh_shapes.h"
#include "services/simulation/worlds/street_site.h"

namespace corbslam {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;

constexpr double kPaintM = 0.015;  // Height of paint above the road.

// Lays a parallelogram on the road, its middle at `at`; false where the road ends.
bool Lay(const Vector2d& at, const Vector2d& ahead, double half_length, double half_width,
         const Finish& finish, StreetSite* site) {
  const Vector2d side(ahead.y(), -ahead.x());
  const auto corner = [&](double along, double across) {
    return Vector2d(at + along * half_length * ahead + across * half_width * side);
  };
  for (const double along : {-1.0, 1.0}) {
    for (const double across : {-1.0, 1.0}) {
      if (site->ground.MiddleDistance(corner(along, across)) > StreetProfile::kKerb - 0.1) {
        return false;
      }
    }
  }
  const auto on_road = [&](double along, double across) -> Vector3f {
    const Vector2d place = corner(along, across);
    return Eigen::Vector3d(place.x(), site->ground.RoadY(place) - kPaintM, place.y()).cast<float>();
  };
  const Vector3f a = on_road(-1, -1);
  const Vector3f b = on_road(-1, 1);
  const Vector3f d = on_road(1, -1);
  AddQuad(a, b, b + (d - a), d, finish, site->chunks.At(at));
  return true;
}

// Adds a zebra where another street comes in soon: bars along the street, side by side across it.
void AddZebra(const Station& station, Dice* dice, StreetSite* site) {
  const Finish paint = {Material::kRoadMarking, dice->Seed(), 1};
  for (double across = -3.6; across < 3.7; across += 0.9) {
    // The stripes are in pieces, because the road bends under them.
    for (const double along : {-1.0, 0.0, 1.0}) {
      const Vector2d at =
          Beside(station, across - StreetProfile::kMiddleLeftOfPath) + along * station.ahead;
      Lay(at, station.ahead, 0.5, 0.22, paint, site);
    }
  }
}

// Adds a dark seam that wanders along the road, where a crack was filled.
void AddSeam(const std::vector<Station>& stations, size_t first, Dice* dice, StreetSite* site) {
  const Finish tar = {Material::kAsphalt, dice->Seed(), dice->Uniformf(0.2, 0.5)};
  double across = dice->Uniform(-3.8, 2.2);
  const double half_width = dice->Uniform(0.02, 0.06);
  Vector2d from = Beside(stations[first], across);
  const int pieces = dice->Integer(4, 22);
  const double wander = dice->Uniform(0.05, 0.35);
  for (int piece = 1; piece <= pieces; ++piece) {
    const size_t at = first + 2 * static_cast<size_t>(piece);
    if (at >= stations.size() || stations[at].driven != stations[first].driven) return;
    across += dice->Uniform(-wander, wander);
    const Vector2d to = Beside(stations[at], across);
    const Vector2d way = to - from;
    if (way.norm() > 0.05) {
      Lay((from + to) / 2, way.normalized(), way.norm() / 2 + 0.02, half_width, tar, site);
    }
    if (dice->Chance(0.3)) {  // A branch across.
      const double length = dice->Uniform(0.4, 1.6);
      const Vector2d side = (stations[at].Right() + dice->Uniform(-0.5, 0.5) * stations[at].ahead);
      Lay(to + length / 2 * side, side.normalized(), length / 2, half_width, tar, site);
    }
    from = to;
  }
}

void AddSpot(const Station& station, Dice* dice, StreetSite* site) {
  const Vector2d at = Beside(station, dice->Uniform(-4, 2));
  if (dice->Chance(0.4)) {  // A manhole or a drain.
    const double half = dice->Uniform(0.2, 0.32);
    Lay(at, station.ahead, half + 0.06, half + 0.06, {Material::kPavement, dice->Seed(), 1}, site);
    const Vector3f centre =
        Eigen::Vector3d(at.x(), site->ground.RoadY(at) - 2 * kPaintM, at.y()).cast<float>();
    if (site->ground.MiddleDistance(at) > StreetProfile::kKerb - 0.5) return;
    AddDisc(centre, -Vector3f::UnitY(), static_cast<float>(half),
            {Material::kMetal, dice->Seed(), 0.6F}, site->chunks.At(at));
    return;
  }
  const Finish patch = {Material::kAsphalt, dice->Seed(), dice->Uniformf(0.5, 1.5)};
  const double across = dice->Uniform(0.3, 0.9);
  const double along = dice->Uniform(0.3, 1.4);
  Lay(at, station.ahead, along, across, patch, site);
}

bool AnotherStreetNear(const Station& station, const StreetSite& site) {
  bool near = false;
  site.path.VisitNear(station.at, 8, [&](const Station& other) {
    near |= (other.at - station.at).norm() < 8 && std::abs(other.ahead.dot(station.ahead)) < 0.5;
  });
  return near;
}

void AddLines(const Station& station, Dice* dice, StreetSite* site) {
  const Finish paint = {Material::kRoadMarking, dice->Seed(), 1};
  for (const double along : {0.0, 1.0, 2.0}) {
    const Vector2d at = Beside(station, -StreetProfile::kMiddleLeftOfPath) + along * station.ahead;
    Lay(at, station.ahead, 0.5, 0.06, paint, site);
  }
}

}  // namespace

void PaintRoad(StreetSite* site) {
  const std::vector<Station>& stations = site->path.stations();
  size_t last_zebra = 0;
  for (size_t i = 0; i + 24 < stations.size(); ++i) {
    const Station& station = stations[i];
    if (station.again) continue;
    Dice dice = site->DiceFor(StreetDice::kRoad, static_cast<int64_t>(i));
    if (dice.Chance(0.055)) AddSeam(stations, i, &dice, site);
    if (dice.Chance(0.05)) AddSpot(station, &dice, site);
    if (i % 12 == 0 && BlockAt(*site, station).middle_line) AddLines(station, &dice, site);
    const bool crossing = stations[i + 24].driven == station.driven &&
                          AnotherStreetNear(stations[i + 24], *site) &&
                          !AnotherStreetNear(station, *site);
    if (crossing && (last_zebra == 0 || i > last_zebra + 60)) {
      last_zebra = i;
      if (dice.Chance(0.7)) AddZebra(station, &dice, site);
    }
  }
}

}  // namespace corbslam
