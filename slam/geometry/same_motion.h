// Tells whether two motions are one and the same number by number, as where something is told anew
// only when it changed.
#ifndef CORBSLAM_SLAM_GEOMETRY_SAME_MOTION_H_
#define CORBSLAM_SLAM_GEOMETRY_SAME_MOTION_H_

#include "slam/geometry/rigid3.h"

namespace corbslam {

inline bool AreSame(const Similarity3d& a, const Similarity3d& b) {
  return a.scale == b.scale && a.translation == b.translation &&
         a.rotation.coeffs() == b.rotation.coeffs();
}

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_GEOMETRY_SAME_MOTION_H_
