// Keeps who stands where: upright boxes on the ground plane that may not overlap.
#ifndef CORBSLAM_SERVICES_SIMULATION_WORLDS_FOOTPRINTS_H_
#define CORBSLAM_SERVICES_SIMULATION_WORLDS_FOOTPRINTS_H_

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "services/simulation/worlds/street_path.h"

namespace corbslam {

// A rectangle of the plane (x, z).
struct Footprint {
  Eigen::Vector2d centre;
  Eigen::Vector2d ahead;  // Unit vector of its length.
  double half_length = 0;
  double half_width = 0;
};

// Returns 0 inside the footprint.
double DistanceTo(const Footprint& footprint, const Eigen::Vector2d& from);
bool Overlap(const Footprint& a, const Footprint& b);

// Not thread-safe.
class Footprints {
 public:
  // It keeps a reference: the path must outlive it.
  explicit Footprints(const StreetPath& path) : path_(path), index_(16) {}

  // Takes the place if it is free and no station lies within the clearance; else returns false.
  bool Take(const Footprint& footprint, double clearance_m);
  bool IsFree(const Footprint& footprint, double clearance_m) const;
  // Visits those that may overlap it.
  void VisitNear(const Footprint& footprint,
                 const std::function<void(const Footprint&)>& visit) const;
  const std::vector<Footprint>& taken() const { return taken_; }

 private:
  const StreetPath& path_;
  PlaneIndex index_;
  std::vector<Footprint> taken_;
  double largest_reach_ = 0;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_WORLDS_FOOTPRINTS_H_
