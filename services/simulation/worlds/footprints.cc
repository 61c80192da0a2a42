#include "services/simulation/worlds/footprints.h"

#include <algorithm>
#include <cmath>

namespace corbslam {
namespace {

using Eigen::Vector2d;

Vector2d Side(const Footprint& footprint) { return {footprint.ahead.y(), -footprint.ahead.x()}; }

double Reach(const Footprint& footprint) {
  return std::hypot(footprint.half_length, footprint.half_width);
}

// Returns half of the footprint's shadow on a line.
double HalfShadow(const Footprint& footprint, const Vector2d& line) {
  return footprint.half_length * std::abs(footprint.ahead.dot(line)) +
         footprint.half_width * std::abs(Side(footprint).dot(line));
}

}  // namespace

double DistanceTo(const Footprint& footprint, const Vector2d& from) {
  const Vector2d offset = from - footprint.centre;
  const double along = std::abs(footprint.ahead.dot(offset)) - footprint.half_length;
  const double across = std::abs(Side(footprint).dot(offset)) - footprint.half_width;
  return std::hypot(std::max(along, 0.0), std::max(across, 0.0));
}

bool Overlap(const Footprint& a, const Footprint& b) {
  const Vector2d offset = b.centre - a.centre;
  for (const Vector2d& line : {a.ahead, Side(a), b.ahead, Side(b)}) {
    if (std::abs(offset.dot(line)) >= HalfShadow(a, line) + HalfShadow(b, line)) return false;
  }
  return true;
}

bool Footprints::IsFree(const Footprint& footprint, double clearance_m) const {
  const double reach = Reach(footprint);
  bool free = true;
  path_.VisitNear(footprint.centre, reach + clearance_m, [&](const Station& station) {
    free = free && DistanceTo(footprint, station.at) >= clearance_m;
  });
  if (!free) return false;
  VisitNear(footprint, [&](const Footprint& other) { free = free && !Overlap(footprint, other); });
  return free;
}

void Footprints::VisitNear(const Footprint& footprint,
                           const std::function<void(const Footprint&)>& visit) const {
  index_.Visit(footprint.centre, Reach(footprint) + largest_reach_,
               [&](uint32_t id) { visit(taken_[id]); });
}

bool Footprints::Take(const Footprint& footprint, double clearance_m) {
  if (!IsFree(footprint, clearance_m)) return false;
  index_.Add(footprint.centre, static_cast<uint32_t>(taken_.size()));
  taken_.push_back(footprint);
  largest_reach_ = std::max(largest_reach_, Reach(footprint));
  return true;
}

}  // namespace corbslam
