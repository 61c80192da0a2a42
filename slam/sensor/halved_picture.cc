#include "slam/sensor/halved_picture.h"

namespace corbslam {
namespace {

cv::Mat HalfOf(const cv::Mat& picture) {
  cv::Mat half(picture.rows / 2, picture.cols / 2, CV_8UC1);
  for (int y = 0; y < half.rows; ++y) {
    const uint8_t* const upper = picture.ptr<uint8_t>(2 * y);
    const uint8_t* const lower = picture.ptr<uint8_t>(2 * y + 1);
    uint8_t* const to = half.ptr<uint8_t>(y);
    for (int x = 0; x < half.cols; ++x) {
      const int sum = upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1];
      to[x] = static_cast<uint8_t>((sum + 2) / 4);
    }
  }
  return half;
}

}  // namespace

uint64_t HalvedPicture::bytes() const {
  uint64_t bytes = 0;
  for (const cv::Mat& level : levels) bytes += level.total() * level.elemSize();
  return bytes;
}

HalvedPicture HalvePicture(const cv::Mat& grey) {
  HalvedPicture halved;
  halved.levels[0] = grey;
  for (size_t i = 1; i < halved.levels.size(); ++i) halved.levels[i] = HalfOf(halved.levels[i - 1]);
  return halved;
}

}  // namespace corbslam
