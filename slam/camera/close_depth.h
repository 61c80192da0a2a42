// Says up to which depth points are measured well, where nobody says it of a camera.
#ifndef CORBSLAM_SLAM_CAMERA_CLOSE_DEPTH_H_
#define CORBSLAM_SLAM_CAMERA_CLOSE_DEPTH_H_

namespace corbslam {

// Camera::close_depth_m of a rig that leaves it out, in baselines.
inline constexpr double kCloseDepth_baselines = 40;

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CAMERA_CLOSE_DEPTH_H_
