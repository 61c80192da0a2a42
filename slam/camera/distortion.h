// Lens distortion of raw images: the radial-tangential (Brown-Conrady) model, as OpenCV's.
#ifndef CORBSLAM_SLAM_CAMERA_DISTORTION_H_
#define CORBSLAM_SLAM_CAMERA_DISTORTION_H_

#include <Eigen/Core>

#include "absl/status/status.h"

namespace corbslam {

// Coefficients over normalised coordinates: r^2 = x^2 + y^2,
// x_d = x (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6) + 2 p1 x y
//       + p2 (r^2 + 2 x^2), y_d likewise. The last three are those of OpenCV's rational model.
struct RadialTangential {
  double k1 = 0;
  double k2 = 0;
  double p1 = 0;
  double p2 = 0;
  double k3 = 0;
  double k4 = 0;
  double k5 = 0;
  double k6 = 0;

  bool IsZero() const { return *this == RadialTangential{}; }
  bool IsRational() const { return k4 != 0 || k5 != 0 || k6 != 0; }
  friend bool operator==(const RadialTangential&, const RadialTangential&) = default;
};

// INVALID_ARGUMENT names the coefficient and its value where one is not finite or beyond 100.
absl::Status Validate(const RadialTangential& distortion);

// Returns the radial factor, by which x and y grow, at the squared radius `r2`.
double RadialFactor(const RadialTangential& distortion, double r2);

// Returns where an ideal normalised point (x/z, y/z) falls through the lens, normalised.
Eigen::Vector2d Distort(const RadialTangential& distortion, const Eigen::Vector2d& ideal);

// Inverts Distort by Newton's method; returns the nearest point found where the model folds over
// (outside the lens's field of view).
Eigen::Vector2d Undistort(const RadialTangential& distortion, const Eigen::Vector2d& distorted);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CAMERA_DISTORTION_H_
