// Draws what a camera of any lens sees, a fisheye of 190 degrees too, from pictures of pinholes.
#ifndef CORBSLAM_SERVICES_SIMULATION_LENS_VIEW_H_
#define CORBSLAM_SERVICES_SIMULATION_LENS_VIEW_H_

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/camera/camera.h"
#include "slam/camera/lens.h"

namespace corbslam {

// A lens that stays within kWidestSlope of its axis is drawn from one pinhole picture. Any other is
// drawn from sides of a cube around the camera, each as far as the lens sees it. A pixel is the
// mean of four places along the lens's own rays. Immutable.
class LensView {
 public:
  // The pinhole pictures are this much finer than the lens where it is finest: docs/simulation.md
  // has the measured errors.
  static constexpr double kFineness = 1.5;
  static constexpr double kWidestSlope = 1.5;

  // One pinhole picture: x_in_camera = camera_from_side * x_in_side.
  struct Side {
    Eigen::Quaterniond camera_from_side;
    Camera pinhole;
  };

  // INVALID_ARGUMENT names what is impossible: the lens's numbers, a size that is not positive, or
  // a lens that sees nothing.
  static absl::StatusOr<LensView> Make(const RawCamera& camera, int width_px, int height_px);

  const std::vector<Side>& sides() const { return sides_; }
  // `light` are CV_32FC1 of the sides' pinholes, in their order. Returns CV_32FC1 of the camera's
  // size, 0 where the lens sees nothing. `threads` changes speed only.
  cv::Mat Resample(const std::vector<cv::Mat>& light, int threads) const;

 private:
  static constexpr int kTaps = 4;
  static constexpr int kNoSide = -1;
  // A place in a side's picture.
  struct Tap {
    float x = 0;
    float y = 0;
    int side = kNoSide;
  };
  LensView() = default;

  int width_px_ = 0;
  int height_px_ = 0;
  std::vector<Side> sides_;
  std::vector<Tap> taps_;  // kTaps for each pixel, by rows.
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_LENS_VIEW_H_
