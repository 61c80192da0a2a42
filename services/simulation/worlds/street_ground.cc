#include "services/simulation/worlds/street_ground.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace corbslam {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;

constexpr double kReachM = 72;  // The ground reaches this far from the path.
// Height of the path above the ground, but for what passes disagree in.
constexpr double kCameraHeightM = 1.65;
// Where passes of one street disagree in height, no camera comes closer to the ground than this.
constexpr double kLowestCameraM = 1.22;
constexpr double kSameGroundM = 4;

template <typename Visit>
void VisitLattice(const Vector2d& at, double reach_m, double step_m, int corners_x, int corners_z,
                  Visit visit) {
  const int low_x = std::max(0, static_cast<int>(std::ceil((at.x() - reach_m) / step_m)));
  const int low_z = std::max(0, static_cast<int>(std::ceil((at.y() - reach_m) / step_m)));
  const int high_x =
      std::min(corners_x - 1, static_cast<int>(std::floor((at.x() + reach_m) / step_m)));
  const int high_z =
      std::min(corners_z - 1, static_cast<int>(std::floor((at.y() + reach_m) / step_m)));
  for (int z = low_z; z <= high_z; ++z) {
    for (int x = low_x; x <= high_x; ++x) {
      visit(static_cast<size_t>(z) * static_cast<size_t>(corners_x) + static_cast<size_t>(x),
            (Vector2d(x, z) * step_m - at).norm());
    }
  }
}

// Returns the heading in parts of a right angle.
int HeadingOf(const Vector2d& ahead, int parts) {
  const double quarters = std::atan2(ahead.y(), ahead.x()) / (std::numbers::pi / 2);
  const double share = quarters - std::floor(quarters);
  return static_cast<int>(std::lround(share * parts)) % parts;
}

}  // namespace

StreetGround::StreetGround(const StreetPath& path) {
  Vector2d low = Vector2d::Constant(std::numeric_limits<double>::max());
  Vector2d high = -low;
  for (const Station& station : path.stations()) {
    low = low.cwiseMin(station.at);
    high = high.cwiseMax(station.at);
  }
  if (path.stations().empty()) return;
  origin_ = ((low.array() - kReachM) / kCellM).floor() * kCellM;
  cells_x_ = static_cast<int>(std::ceil((high.x() + kReachM - origin_.x()) / kCellM));
  cells_z_ = static_cast<int>(std::ceil((high.y() + kReachM - origin_.y()) / kCellM));
  MeasureMiddles(path);
  MeasureHeights(path);
}

void StreetGround::MeasureMiddles(const StreetPath& path) {
  const int corners_x = kFine * cells_x_ + 1;
  const int corners_z = kFine * cells_z_ + 1;
  middle_m_.assign(static_cast<size_t>(corners_x) * static_cast<size_t>(corners_z),
                   static_cast<float>(kFarM));
  heading_.assign(middle_m_.size(), 0);
  for (const Station& station : path.stations()) {
    const Vector2d middle = station.at - StreetProfile::kMiddleLeftOfPath * station.Right();
    const auto heading = static_cast<uint8_t>(HeadingOf(station.ahead, kHeadings));
    VisitLattice(middle - origin_, kFarM, kFineM, corners_x, corners_z,
                 [&](size_t corner, double distance) {
                   if (distance >= static_cast<double>(middle_m_[corner])) return;
                   middle_m_[corner] = static_cast<float>(distance);
                   heading_[corner] = heading;
                 });
  }
}

void StreetGround::MeasureHeights(const StreetPath& path) {
  const int corners_x = cells_x_ + 1;
  const int corners_z = cells_z_ + 1;
  const size_t count = static_cast<size_t>(corners_x) * static_cast<size_t>(corners_z);
  std::vector<double> weights(count, 0);
  std::vector<double> sums(count, 0);
  std::vector<double> lowest(count, -std::numeric_limits<double>::max());
  for (const Station& station : path.stations()) {
    VisitLattice(station.at - origin_, kReachM, kCellM, corners_x, corners_z,
                 [&](size_t corner, double distance) {
                   if (distance > kReachM) return;
                   const double falls = distance * distance + 1;
                   const double weight = 1 / (falls * falls);
                   weights[corner] += weight;
                   sums[corner] += weight * (station.camera_y + kCameraHeightM);
                   if (distance > kSameGroundM) return;
                   lowest[corner] = std::max(lowest[corner], station.camera_y + kLowestCameraM);
                 });
  }
  height_.assign(count, std::numeric_limits<float>::quiet_NaN());
  for (size_t i = 0; i < count; ++i) {
    if (weights[i] > 0) height_[i] = static_cast<float>(std::max(sums[i] / weights[i], lowest[i]));
  }
}

double StreetGround::RoadY(const Vector2d& at) const {
  if (height_.empty()) return 0;
  const Vector2d cell = (at - origin_) / kCellM;
  const int x = std::clamp(static_cast<int>(std::floor(cell.x())), 0, cells_x_ - 1);
  const int z = std::clamp(static_cast<int>(std::floor(cell.y())), 0, cells_z_ - 1);
  const double u = std::clamp(cell.x() - x, 0.0, 1.0);
  const double v = std::clamp(cell.y() - z, 0.0, 1.0);
  const auto corner = [&](int dx, int dz) {
    const size_t row = static_cast<size_t>(cells_x_) + 1;
    return static_cast<double>(
        height_[static_cast<size_t>(z + dz) * row + static_cast<size_t>(x + dx)]);
  };
  // The diagonal runs from corner (0, 0) to (1, 1).
  const double y =
      u > v ? corner(0, 0) + u * (corner(1, 0) - corner(0, 0)) + v * (corner(1, 1) - corner(1, 0))
            : corner(0, 0) + v * (corner(0, 1) - corner(0, 0)) + u * (corner(1, 1) - corner(0, 1));
  return std::isfinite(y) ? y : 0;
}

double StreetGround::MiddleDistance(const Vector2d& at) const {
  const Vector2d cell = (at - origin_) / kFineM;
  const int corners_x = kFine * cells_x_ + 1;
  const int x = static_cast<int>(std::floor(cell.x()));
  const int z = static_cast<int>(std::floor(cell.y()));
  if (x < 0 || z < 0 || x >= kFine * cells_x_ || z >= kFine * cells_z_) return kFarM;
  const double u = cell.x() - x;
  const double v = cell.y() - z;
  const auto corner = [&](int dx, int dz) {
    return static_cast<double>(
        middle_m_[static_cast<size_t>(z + dz) * static_cast<size_t>(corners_x) +
                  static_cast<size_t>(x + dx)]);
  };
  return (1 - v) * ((1 - u) * corner(0, 0) + u * corner(1, 0)) +
         v * ((1 - u) * corner(0, 1) + u * corner(1, 1));
}

double StreetGround::GroundY(const Vector2d& at) const {
  const double raised =
      MiddleDistance(at) > StreetProfile::kKerb ? StreetProfile::kKerbHeight : 0.0;
  return RoadY(at) - raised;
}

}  // namespace corbslam
