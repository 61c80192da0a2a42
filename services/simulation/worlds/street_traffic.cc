// Drives cars along the path: oncoming, overtaking and leading ones.
#include <algorithm>
#include <cmath>

#include "services/simulation/worlds/cars.h"
#include "services/simulation/worlds/street_site.h"

namespace corbslam {
namespace {

using Eigen::Vector2d;

constexpr double kOtherLaneM = 3.1;  // The other lane is left of the path.
constexpr double kSeenAheadM = 95;   // A mover comes into being this far ahead,
constexpr double kGoneBehindM = 25;  // and vanishes this far behind.
constexpr double kSideClearanceM = 0.25;
constexpr double kBuriedM = 60;  // Movers that aren't there lie this deep.
constexpr double kStepS = 0.2;

enum class Manner { kOncoming, kOvertaking, kLeading };

// The path by time: where the robot is along it, and stations by the way driven.
class Timeline {
 public:
  Timeline(const StreetPath& path, double rate_hz, size_t poses) : path_(path) {
    for (const Station& station : path.stations()) {
      if (!station.driven) break;
      times_.push_back(station.frame / rate_hz);
    }
    end_s_ = static_cast<double>(poses) / rate_hz;
  }
  double end_s() const { return end_s_; }
  double end_m() const { return static_cast<double>(times_.size() - 1) * StreetPath::kStepM; }

  double WayAt(double time_s) const {
    const auto after = std::upper_bound(times_.begin(), times_.end(), time_s);
    return static_cast<double>(after - times_.begin()) * StreetPath::kStepM;
  }
  const Station& At(double way_m) const {
    const double index = std::round(way_m / StreetPath::kStepM);
    const double last = static_cast<double>(times_.size() - 1);
    return path_.stations()[static_cast<size_t>(std::clamp(index, 0.0, last))];
  }

 private:
  const StreetPath& path_;
  std::vector<double> times_;
  double end_s_ = 0;
};

struct Drive {
  Manner manner = Manner::kOncoming;
  double start_s = 0;
  double speed = 9;
};

// Returns the place along the path and to its right at a time since the start; false once the drive
// is over.
bool PlaceAt(const Drive& drive, const Timeline& timeline, double start_m, double since_s,
             double* way_m, double* lateral_m) {
  const double ego_m = timeline.WayAt(drive.start_s + since_s);
  switch (drive.manner) {
    case Manner::kOncoming:
      *way_m = start_m + kSeenAheadM - drive.speed * since_s;
      *lateral_m = -kOtherLaneM;
      return *way_m > ego_m - kGoneBehindM && *way_m > 1;
    case Manner::kOvertaking:
      *way_m = start_m - kGoneBehindM + drive.speed * since_s;
      *lateral_m = -kOtherLaneM;
      return *way_m < ego_m + kSeenAheadM;
    case Manner::kLeading: {
      // The car comes into being far ahead, lets the robot come nearer, and drives off again.
      const double gap = 14 + 4 * std::abs(since_s - 20);
      *way_m = ego_m + gap;
      *lateral_m = 0;
      return since_s < 40;
    }
  }
  return false;
}

bool IsClear(const StreetSite& site, const Vector2d& at, const Vector2d& ahead,
             const CarPrototype& car) {
  const Footprint own = {at, ahead, static_cast<double>(car.length) / 2,
                         static_cast<double>(car.width) / 2 + kSideClearanceM};
  bool clear = site.ground.MiddleDistance(at) < StreetProfile::kKerb - 0.6;
  site.footprints.VisitNear(own, [&](const Footprint& other) { clear &= !Overlap(own, other); });
  return clear;
}

// With `whole` the drive is planned only if the path is long enough for all of it; otherwise it may
// come from where the path begins and go on behind its end.
bool PlanDrive(const Drive& drive, const Timeline& timeline, const CarPrototype& car,
               const StreetSite& site, bool whole, Mover* mover) {
  const double start_m = timeline.WayAt(drive.start_s);
  double way = 0;
  double lateral = 0;
  for (double since = 0; PlaceAt(drive, timeline, start_m, since, &way, &lateral);
       since += kStepS) {
    if (way < 1 || way > timeline.end_m() - 1 || drive.start_s + since > timeline.end_s()) {
      if (whole) return false;
      if (mover->path.empty()) continue;
      break;
    }
    const Station& station = timeline.At(way);
    const double between = way - station.along_m;
    const Vector2d at = Beside(station, lateral) + between * station.ahead;
    const Vector2d ahead =
        drive.manner == Manner::kOncoming ? Vector2d(-station.ahead) : station.ahead;
    if (!IsClear(site, at, ahead, car)) return false;
    mover->path.push_back({drive.start_s + since, OnRoad(site.ground, at, ahead)});
  }
  return mover->path.size() > 10;
}

// Before and after its drive the mover lies deep under the street.
void Bury(Mover* mover) {
  Mover::Waypoint before = mover->path.front();
  before.time_s -= 1e-3;
  before.world_from_mesh.translation.y() += kBuriedM;
  Mover::Waypoint after = mover->path.back();
  after.time_s += 1e-3;
  after.world_from_mesh.translation.y() += kBuriedM;
  mover->path.insert(mover->path.begin(), before);
  mover->path.push_back(after);
}

}  // namespace

void DriveMovers(const std::vector<Rigid3d>& world_from_camera, StreetSite* site) {
  const int count = site->options.moving_cars;
  if (count <= 0 || world_from_camera.size() < 2) return;
  const Timeline timeline(site->path, site->options.frame_rate_hz, world_from_camera.size());
  Dice prototypes = site->DiceFor(StreetDice::kPrototypes, 4);
  const std::vector<CarPrototype> cars = BuildCarPrototypes(prototypes.Next());
  const auto first = static_cast<uint32_t>(site->scene.meshes.size());
  for (const CarPrototype& car : cars) site->AddMesh(car.mesh);
  for (int i = 0; i < count; ++i) {
    Dice dice = site->DiceFor(StreetDice::kTraffic, i);
    const auto which = static_cast<size_t>(dice.Integer(0, static_cast<int>(cars.size()) - 1));
    constexpr int kTries = 90;
    for (int attempt = 0; attempt < kTries; ++attempt) {
      Drive drive;
      drive.manner = i % 5 == 4   ? Manner::kLeading
                     : i % 5 == 2 ? Manner::kOvertaking
                                  : Manner::kOncoming;
      // Each drive has its share of the time; a drive that finds no room there looks anywhere, and
      // at last takes less of the path.
      const double share = timeline.end_s() / count;
      drive.start_s = attempt < kTries / 3 ? share * (i + dice.Uniform(0, 1))
                                           : dice.Uniform(0, timeline.end_s());
      drive.speed =
          drive.manner == Manner::kOvertaking ? dice.Uniform(14, 18) : dice.Uniform(6, 11);
      Mover mover;
      mover.mesh = first + static_cast<uint32_t>(which);
      mover.seed = dice.Seed();
      const bool whole = attempt < 2 * kTries / 3;
      if (!PlanDrive(drive, timeline, cars[which], *site, whole, &mover)) continue;
      Bury(&mover);
      site->scene.movers.push_back(std::move(mover));
      break;
    }
  }
}

}  // namespace corbslam
