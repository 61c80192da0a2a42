// The driven path as the street sees it: evenly spaced stations and where they are near.
#ifndef CORBSLAM_SERVICES_SIMULATION_WORLDS_STREET_PATH_H_
#define CORBSLAM_SERVICES_SIMULATION_WORLDS_STREET_PATH_H_

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "slam/geometry/rigid3.h"

namespace corbslam {

// A point of the path; 2-vectors are (x, z).
struct Station {
  Eigen::Vector2d at;
  Eigen::Vector2d ahead;  // Unit vector of the direction of travel.
  double camera_y = 0;
  double frame = 0;    // Index of the pose, with a fraction between poses.
  double along_m = 0;  // Way from the first pose.
  bool again = false;  // This stretch of street has been driven before.
  bool driven = true;  // False for a street that leads on where the path begins, turns or ends.

  Eigen::Vector2d Right() const { return {ahead.y(), -ahead.x()}; }
};

// Points of the plane by place, visited in the order they were added within a cell and by cell
// otherwise: the same every time.
class PlaneIndex {
 public:
  explicit PlaneIndex(double cell_m) : cell_m_(cell_m) {}

  void Add(const Eigen::Vector2d& at, uint32_t id);
  // Visits every id within the square of half width `reach_m` round `centre`, and some beyond.
  void Visit(const Eigen::Vector2d& centre, double reach_m,
             const std::function<void(uint32_t)>& visit) const;

 private:
  using Cell = std::pair<int32_t, int32_t>;
  Cell CellOf(const Eigen::Vector2d& at) const;

  double cell_m_;
  std::map<Cell, std::vector<uint32_t>> ids_;
};

// Immutable after construction; thread-safe.
class StreetPath {
 public:
  static constexpr double kStepM = 0.5;

  explicit StreetPath(const std::vector<Rigid3d>& world_from_camera);

  // Returns the driven stations in order, then those of the streets that lead on.
  const std::vector<Station>& stations() const { return stations_; }
  void VisitNear(const Eigen::Vector2d& centre, double reach_m,
                 const std::function<void(const Station&)>& visit) const;
  // Returns the distance to the nearest station, or `limit_m` if there is none so near.
  double Distance(const Eigen::Vector2d& from, double limit_m) const;

 private:
  void Resample(const std::vector<Rigid3d>& world_from_camera);
  void MarkRepeated();
  void LeadOn();
  void AddBranch(const Station& from, const Eigen::Vector2d& ahead, double length_m);
  void Add(const Station& station);

  std::vector<Station> stations_;
  PlaneIndex index_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_WORLDS_STREET_PATH_H_
