// Maps 3-space to the plane of a picture that shows a map from above.
#ifndef CORBSLAM_SLAM_RENDERING_VIEW_FROM_ABOVE_H_
#define CORBSLAM_SLAM_RENDERING_VIEW_FROM_ABOVE_H_

#include <Eigen/Core>
#include <vector>

#include "slam/geometry/rigid3.h"

namespace corbslam {

// The rows are the world directions that lie to the right and downwards in the picture.
using PlaneFromWorld = Eigen::Matrix<double, 2, 3>;

// Looks along the mean of the cameras' y axes (downwards, for robots that stand upright); where
// that mean is shorter than 0.3, along the direction of least motion. The direction of most motion
// within the plane lies across. `world_from_cameras` must not be empty.
PlaneFromWorld LookFromAbove(const std::vector<Rigid3d>& world_from_cameras);

struct Bounds {
  Eigen::Vector2d low = Eigen::Vector2d::Zero();
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
  Eigen::Vector2d Size() const { return high - low; }
  bool Contains(const Eigen::Vector2d& x) const {
    return (x.array() >= low.array()).all() && (x.array() <= high.array()).all();
  }
};

// Returns what the picture shows: all of `paths`, and the middle 96 % of `points` as far as they
// lie within 1.4 times the paths' extent, or of each axis within the middle 80 % and 8 times that
// extent. The bounds are never of zero size. `paths` must not be empty.
Bounds ChooseBounds(const std::vector<Eigen::Vector2d>& paths,
                    const std::vector<Eigen::Vector2d>& points);

// Returns the length of a scale bar: 1, 2 or 5 times a power of ten, the largest not above `most` >
// 0.
double RoundLength(double most);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_RENDERING_VIEW_FROM_ABOVE_H_
