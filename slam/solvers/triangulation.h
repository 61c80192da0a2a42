// Computes a point from two views of it.
#ifndef CORBSLAM_SLAM_SOLVERS_TRIANGULATION_H_
#define CORBSLAM_SLAM_SOLVERS_TRIANGULATION_H_

#include <Eigen/Core>
#include <optional>

#include "slam/camera/camera.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

struct TriangulatedPoint {
  Eigen::Vector3d x_in_map;
  // Cosine of the angle between the two rays (of the pixels, not of the point found): near 1 is
  // little parallax.
  double parallax_cosine = 1;
  // Depths along the cameras' axes; always positive.
  double depth_1 = 0;
  double depth_2 = 0;
};

// Returns the midpoint with inverse depths' weighting (Lee and Civera, "Triangulation: Why
// Optimize?", BMVC 2019); nothing where the rays are parallel or the point falls behind a camera.
// It checks no reprojection error and allocates nothing. Pure; any thread.
std::optional<TriangulatedPoint> TriangulatePoint(
    const Camera& camera_1, const Rigid3d& camera_1_from_map, const Eigen::Vector2d& pixel_1,
    const Camera& camera_2, const Rigid3d& camera_2_from_map, const Eigen::Vector2d& pixel_2);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SOLVERS_TRIANGULATION_H_
