#include "client_agent/source/rig/rectified_motion.h"

#include <Eigen/Geometry>

namespace corbslam::client_agent {

Rigid3d MotionOfRectified(const Eigen::Matrix3d& left_rotation,
                          const Eigen::Matrix3d& right_rotation, double baseline_m) {
  // A point of the rectified left frame has x less by the baseline in the rectified right one.
  Rigid3d motion;
  motion.rotation =
      Eigen::Quaterniond(Eigen::Matrix3d(right_rotation.transpose() * left_rotation)).normalized();
  motion.translation = right_rotation.transpose() * Eigen::Vector3d(-baseline_m, 0, 0);
  return motion;
}

}  // namespace corbslam::client_agent
