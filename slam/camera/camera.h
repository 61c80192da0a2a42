// A calibrated camera whose images are (or have been) undistorted, with what makes depth: the
// baseline of a rectified stereo pair, or a virtual one for RGB-D.
#ifndef CORBSLAM_SLAM_CAMERA_CAMERA_H_
#define CORBSLAM_SLAM_CAMERA_CAMERA_H_

#include <Eigen/Core>
#include <optional>

#include "absl/status/status.h"

namespace corbslam {

// Pinhole intrinsics of undistorted (for stereo: rectified) images. All keypoints of the system
// are in this camera's pixels. Metric cameras have baseline_m > 0.
struct Camera {
  double fx_px = 0;
  double fy_px = 0;
  double cx_px = 0;
  double cy_px = 0;
  int width_px = 0;
  int height_px = 0;
  // Distance between the two cameras of a rectified pair, or a virtual one for RGB-D (0.08 m);
  // disparity_px = fx_px * baseline_m / depth_m. 0: monocular, the map has no scale.
  double baseline_m = 0;
  // Points nearer than this have depth good enough to be created from one view:
  // about 40 baselines for stereo, the sensor's range for RGB-D.
  double close_depth_m = 0;

  bool IsMetric() const { return baseline_m > 0; }
  friend bool operator==(const Camera&, const Camera&) = default;
};

// INVALID_ARGUMENT names the field and its value where a calibration is impossible.
absl::Status Validate(const Camera& camera);

// Returns the pixel of a point in the camera's frame; its depth must be positive.
inline Eigen::Vector2d Project(const Camera& camera, const Eigen::Vector3d& x_in_camera) {
  return {camera.fx_px * x_in_camera.x() / x_in_camera.z() + camera.cx_px,
          camera.fy_px * x_in_camera.y() / x_in_camera.z() + camera.cy_px};
}

// Returns the point in the camera's frame at `depth_m` (z) behind pixel (x, y).
inline Eigen::Vector3d Unproject(const Camera& camera, double x_px, double y_px, double depth_m) {
  return {(x_px - camera.cx_px) / camera.fx_px * depth_m,
          (y_px - camera.cy_px) / camera.fy_px * depth_m, depth_m};
}

inline double DisparityFromDepth(const Camera& camera, double depth_m) {
  return camera.fx_px * camera.baseline_m / depth_m;
}
inline double DepthFromDisparity(const Camera& camera, double disparity_px) {
  return camera.fx_px * camera.baseline_m / disparity_px;
}

inline bool IsInImage(const Camera& camera, const Eigen::Vector2d& pixel) {
  return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < camera.width_px &&
         pixel.y() < camera.height_px;
}

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CAMERA_CAMERA_H_
