// Smooth paths in the ground plane, sampled densely.
#ifndef CORBSLAM_SERVICES_SIMULATION_MOTION_PLANE_PATH_H_
#define CORBSLAM_SERVICES_SIMULATION_MOTION_PLANE_PATH_H_

#include <Eigen/Core>
#include <vector>

namespace corbslam {

// The samples are `spacing_m` apart. Headings are those of travel, radians from +z towards +x, and
// run on beyond pi: a full turn to the right ends 2 pi higher.
struct PlanePath {
  double spacing_m = 0.1;
  std::vector<Eigen::Vector2d> points;  // (x, z), metres.
  std::vector<double> headings_rad;
};

struct PlanePathOptions {
  double spacing_m = 0.1;
  // Arcs replace corners; they begin and end this far before and behind, or as far as half of the
  // shorter leg allows.
  double corner_m = 8;
  // Least radius of those arcs, where the legs are long enough.
  double least_radius_m = 6;
  // Standard deviations of the Gaussians by which points and headings are smoothed along the path.
  double point_smoothing_m = 2;
  double heading_smoothing_m = 0;
  // The way goes from the last waypoint back to the first, and on for `lead_out_m` from there.
  bool closed = false;
  double lead_out_m = 0;
};

// `corners_m`, when not empty, overrides corner_m for each waypoint. Waypoints that coincide with
// the one before are left out; fewer than two give an empty path.
PlanePath MakePlanePath(const std::vector<Eigen::Vector2d>& waypoints,
                        const PlanePathOptions& options, const std::vector<double>& corners_m = {});

// Returns the headings of travel along points, by central differences; they run on beyond pi.
std::vector<double> ComputeHeadings(const std::vector<Eigen::Vector2d>& points);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_MOTION_PLANE_PATH_H_
