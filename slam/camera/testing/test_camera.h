// A camera for tests that need any.
#ifndef CORBSLAM_SLAM_CAMERA_TESTING_TEST_CAMERA_H_
#define CORBSLAM_SLAM_CAMERA_TESTING_TEST_CAMERA_H_

#include <memory>

#include "slam/camera/camera.h"

namespace corbslam::testing {

// Returns a stereo camera of 640 x 480 pixels without distortion.
inline std::shared_ptr<const Camera> TestCamera() {
  static const auto camera = std::make_shared<const Camera>(Camera{.fx_px = 500,
                                                                   .fy_px = 500,
                                                                   .cx_px = 320,
                                                                   .cy_px = 240,
                                                                   .width_px = 640,
                                                                   .height_px = 480,
                                                                   .baseline_m = 0.1});
  return camera;
}

// Returns the rectified pair of a car: KITTI's sequence 00, 1241 x 376 pixels.
inline Camera CarCamera() {
  return {.fx_px = 718.9,
          .fy_px = 718.9,
          .cx_px = 607.2,
          .cy_px = 185.2,
          .width_px = 1241,
          .height_px = 376,
          .baseline_m = 0.54};
}

}  // namespace corbslam::testing

#endif  // CORBSLAM_SLAM_CAMERA_TESTING_TEST_CAMERA_H_
