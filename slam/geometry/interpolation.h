#ifndef CORBSLAM_SLAM_GEOMETRY_INTERPOLATION_H_
#define CORBSLAM_SLAM_GEOMETRY_INTERPOLATION_H_

#include "slam/geometry/rigid3.h"

namespace corbslam {

// Returns `a` at share 0 and `b` at 1: rotations go along the shortest arc, translations along the
// line.
inline Rigid3d Interpolate(const Rigid3d& a, const Rigid3d& b, double share) {
  return {a.rotation.slerp(share, b.rotation), (1 - share) * a.translation + share * b.translation};
}

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_GEOMETRY_INTERPOLATION_H_
