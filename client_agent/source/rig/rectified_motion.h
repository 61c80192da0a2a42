// How two cameras lie to each other of which only the rectification is known.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_RIG_RECTIFIED_MOTION_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_RIG_RECTIFIED_MOTION_H_

#include <Eigen/Core>

#include "slam/geometry/rigid3.h"

namespace corbslam::client_agent {

// Returns right_from_left of a pair of which only the rectification is known: each camera's
// rotation rectified_from_camera and the baseline of the rectified pair.
Rigid3d MotionOfRectified(const Eigen::Matrix3d& left_rotation,
                          const Eigen::Matrix3d& right_rotation, double baseline_m);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_RIG_RECTIFIED_MOTION_H_
