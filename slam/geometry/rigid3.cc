#include "slam/geometry/rigid3.h"

#include <cmath>

namespace corbslam {

double RotationAngle(const Eigen::Quaterniond& rotation) {
  return 2.0 * std::atan2(rotation.vec().norm(), std::abs(rotation.w()));
}

}  // namespace corbslam
