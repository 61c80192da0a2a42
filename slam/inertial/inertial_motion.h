// How the camera moved, as an IMU felt it, and which way is down.
#ifndef CORBSLAM_SLAM_INERTIAL_INERTIAL_MOTION_H_
#define CORBSLAM_SLAM_INERTIAL_INERTIAL_MOTION_H_

#include <Eigen/Core>
#include <cstdint>

#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

// Two poses are further apart once in a thousand times by chance: squared and in units of what both
// may be off by, of six degrees of freedom.
constexpr double kUsualDistance = 22.5;

// Since the last frame that had a pose by pictures.
struct InertialMotion {
  Rigid3d camera_from_previous;
  int64_t since_ns = 0;
  // Of the camera's pose in the previous one's frame: of its position along and its rotation about
  // the previous camera's axes.
  Matrix6d covariance = Matrix6d::Identity();
};

// Where gravity pulls, in the axes of the camera of the last frame that had a pose.
struct Down {
  Eigen::Vector3d in_camera = Eigen::Vector3d::UnitY();
  double sigma_rad = 0;  // Of its direction, any way.
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_INERTIAL_INERTIAL_MOTION_H_
