// A grey picture in five sizes, each half as wide as the one before.
#ifndef CORBSLAM_SLAM_SENSOR_HALVED_PICTURE_H_
#define CORBSLAM_SLAM_SENSOR_HALVED_PICTURE_H_

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>

namespace corbslam {

struct HalvedPicture {
  static constexpr int kLevels = 5;

  // CV_8UC1. Each pixel of a level is the mean of four of the level before; an odd last row or
  // column of that is left out.
  std::array<cv::Mat, kLevels> levels;

  // Returns the bytes of all levels.
  uint64_t bytes() const;
};

// `grey` (CV_8UC1, at least 16 x 16 pixels) is shared, not copied: levels[0] are its pixels.
HalvedPicture HalvePicture(const cv::Mat& grey);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_HALVED_PICTURE_H_
