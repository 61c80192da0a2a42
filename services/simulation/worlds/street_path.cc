#include "services/simulation/worlds/street_path.h"

#include <algorithm>
#include <cmath>

namespace corbslam {
namespace {

using Eigen::Vector2d;

// Poses further back than this on the same stretch belong to an earlier pass.
constexpr double kSamePassM = 40;
constexpr double kSameStreetM = 6;
// Streets that lead on where the path begins, turns or ends.
constexpr double kBranchM = 110;
constexpr double kShortestBranchM = 45;
constexpr double kBranchClearanceM = 16;
constexpr double kTurnM = 12;
constexpr double kTurnCosine = 0.6;

Vector2d Plane(const Eigen::Vector3d& point) { return {point.x(), point.z()}; }

}  // namespace

PlaneIndex::Cell PlaneIndex::CellOf(const Vector2d& at) const {
  return {static_cast<int32_t>(std::floor(at.x() / cell_m_)),
          static_cast<int32_t>(std::floor(at.y() / cell_m_))};
}

void PlaneIndex::Add(const Vector2d& at, uint32_t id) { ids_[CellOf(at)].push_back(id); }

void PlaneIndex::Visit(const Vector2d& centre, double reach_m,
                       const std::function<void(uint32_t)>& visit) const {
  const Cell low = CellOf(centre - Vector2d::Constant(reach_m));
  const Cell high = CellOf(centre + Vector2d::Constant(reach_m));
  for (int32_t x = low.first; x <= high.first; ++x) {
    for (auto it = ids_.lower_bound({x, low.second});
         it != ids_.end() && it->first <= Cell{x, high.second}; ++it) {
      for (const uint32_t id : it->second) visit(id);
    }
  }
}

StreetPath::StreetPath(const std::vector<Rigid3d>& world_from_camera) : index_(8) {
  Resample(world_from_camera);
  for (size_t i = 0; i < stations_.size(); ++i) {
    index_.Add(stations_[i].at, static_cast<uint32_t>(i));
  }
  MarkRepeated();
  LeadOn();
}

void StreetPath::Resample(const std::vector<Rigid3d>& world_from_camera) {
  double along = 0;
  double next = 0;
  for (size_t i = 0; i + 1 < world_from_camera.size(); ++i) {
    const Eigen::Vector3d& from = world_from_camera[i].translation;
    const Eigen::Vector3d& to = world_from_camera[i + 1].translation;
    const double length = (Plane(to) - Plane(from)).norm();
    for (; next < along + length; next += kStepM) {
      const double share = (next - along) / length;
      const Eigen::Vector3d point = (1 - share) * from + share * to;
      Station station;
      station.at = Plane(point);
      station.camera_y = point.y();
      station.frame = static_cast<double>(i) + share;
      station.along_m = next;
      stations_.push_back(station);
    }
    along += length;
  }
  if (stations_.empty() && !world_from_camera.empty()) {
    Station station;
    station.at = Plane(world_from_camera[0].translation);
    station.camera_y = world_from_camera[0].translation.y();
    stations_.push_back(station);
  }
  // The direction is taken over two metres each way: single poses jitter, most of all where a car
  // stands.
  const size_t reach = 4;
  for (size_t i = 0; i < stations_.size(); ++i) {
    const size_t last = std::min(i + reach, stations_.size() - 1);
    const Vector2d way = stations_[last].at - stations_[i < reach ? 0 : i - reach].at;
    const Vector2d looks = stations_.size() > 1 || world_from_camera.empty()
                               ? Vector2d(0, 1)
                               : Plane(world_from_camera[0].rotation * Eigen::Vector3d::UnitZ());
    stations_[i].ahead = way.norm() > 1e-6 ? way.normalized() : looks.normalized();
  }
}

void StreetPath::MarkRepeated() {
  for (Station& station : stations_) {
    VisitNear(station.at, kSameStreetM, [&](const Station& other) {
      if (other.along_m + kSamePassM < station.along_m &&
          (other.at - station.at).norm() < kSameStreetM &&
          std::abs(other.ahead.dot(station.ahead)) > 0.7) {
        station.again = true;
      }
    });
  }
}

void StreetPath::Add(const Station& station) {
  index_.Add(station.at, static_cast<uint32_t>(stations_.size()));
  stations_.push_back(station);
}

void StreetPath::AddBranch(const Station& from, const Vector2d& ahead, double length_m) {
  std::vector<Station> branch;
  for (double way = kStepM; way < length_m; way += kStepM) {
    Station station = from;
    station.at += way * ahead;
    station.ahead = ahead;
    station.again = false;
    station.driven = false;
    bool meets = false;
    VisitNear(station.at, kBranchClearanceM, [&](const Station& other) {
      const bool own_corner = (other.at - from.at).norm() < 2 * kBranchClearanceM;
      meets |= !own_corner && (other.at - station.at).norm() < kBranchClearanceM;
    });
    if (meets) break;
    branch.push_back(station);
  }
  // A stub that ends at the next street's back gardens is worse than none.
  if (static_cast<double>(branch.size()) * kStepM < kShortestBranchM) return;
  for (const Station& station : branch) Add(station);
}

void StreetPath::LeadOn() {
  const size_t driven = stations_.size();
  if (driven == 0) return;
  AddBranch(Station(stations_[0]), -stations_[0].ahead, kBranchM);
  AddBranch(Station(stations_[driven - 1]), stations_[driven - 1].ahead, kBranchM);
  const size_t reach = static_cast<size_t>(kTurnM / kStepM);
  for (size_t i = reach; i + reach < driven; ++i) {
    const Station turn = stations_[i];
    const Vector2d before = stations_[i - reach].ahead;
    const Vector2d after = stations_[i + reach].ahead;
    if (before.dot(after) > kTurnCosine || turn.again) continue;
    AddBranch(turn, before, kBranchM);
    i += 2 * reach;
  }
}

void StreetPath::VisitNear(const Vector2d& centre, double reach_m,
                           const std::function<void(const Station&)>& visit) const {
  index_.Visit(centre, reach_m, [&](uint32_t id) { visit(stations_[id]); });
}

double StreetPath::Distance(const Vector2d& from, double limit_m) const {
  double nearest = limit_m;
  VisitNear(from, limit_m, [&](const Station& station) {
    nearest = std::min(nearest, (station.at - from).norm());
  });
  return nearest;
}

}  // namespace corbslam
