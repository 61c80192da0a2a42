// Finds how a whole picture moved since the one before: by what the camera turned, mostly.
#ifndef CORBSLAM_SLAM_SENSOR_PICTURE_SHIFT_H_
#define CORBSLAM_SLAM_SENSOR_PICTURE_SHIFT_H_

#include <Eigen/Core>
#include <optional>

#include "slam/sensor/halved_picture.h"

namespace corbslam {

// What was at x in the picture before is now at m + R (x - m) + shift_px, m the picture's middle
// and R a rotation from the x to the y axis.
struct PictureShift {
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();  // Pixels of the first level.
  double turn_rad = 0;
};

// Aligns the smallest two levels of two pictures of one size (Klein and Murray, ECCV 2008, use such
// pictures likewise). Nullopt where they do not come to look alike.
std::optional<PictureShift> FindPictureShift(const HalvedPicture& before, const HalvedPicture& now);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_PICTURE_SHIFT_H_
