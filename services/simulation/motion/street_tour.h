// A drive through a town: a way over a random grid of streets that comes back to where it began.
#ifndef CORBSLAM_SERVICES_SIMULATION_MOTION_STREET_TOUR_H_
#define CORBSLAM_SERVICES_SIMULATION_MOTION_STREET_TOUR_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace corbslam {

struct StreetTourOptions {
  uint64_t seed = 1;
  // Length of the closed way, from crossing to crossing; the arcs of corners make it a little
  // shorter.
  double length_m = 1500;
};

struct StreetTour {
  std::vector<Eigen::Vector2d> crossings;  // (x, z) in the order they are passed; closed.
  double length_m = 0;                     // Length straight from crossing to crossing.
  double repeated_m = 0;  // The part of it on streets that were driven before, either way.
};

// From about 500 m on, the way has streets that are driven twice and crossings that are passed in
// more than one direction; it never turns back in a street. A shorter one goes round one block.
// Blocks are 60 to 110 m long, smaller when the length asks for it (least 40 m in all).
StreetTour MakeStreetTour(const StreetTourOptions& options);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_MOTION_STREET_TOUR_H_
