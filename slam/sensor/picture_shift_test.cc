#include "slam/sensor/picture_shift.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

namespace corbslam {
namespace {

// A scene that is seen turned by `turn_rad` about the picture's middle and moved by `moved`.
cv::Mat Draw(const Eigen::Vector2d& moved, double turn_rad, double contrast = 1) {
  cv::Mat picture(480, 640, CV_8UC1);
  const Eigen::Vector2d middle(319.5, 239.5);
  const double c = std::cos(turn_rad);
  const double s = std::sin(turn_rad);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const Eigen::Vector2d p = Eigen::Vector2d(x, y) - middle - moved;
      const Eigen::Vector2d w(c * p.x() + s * p.y(), -s * p.x() + c * p.y());
      const double value =
          128 + contrast * (50 * std::sin(0.021 * w.x() + std::sin(0.013 * w.y())) +
                            40 * std::cos(0.027 * w.y() - 0.011 * w.x()));
      picture.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(value);
    }
  }
  return picture;
}

TEST(FindPictureShiftTest, FindsShiftAndTurn) {
  const HalvedPicture before = HalvePicture(Draw({0, 0}, 0));
  for (const auto& [moved, turn] :
       {std::pair<Eigen::Vector2d, double>({0, 0}, 0), {{25, -17}, 0}, {{-40, 10}, 0.05}}) {
    const auto shift = FindPictureShift(before, HalvePicture(Draw(moved, turn, 0.7)));
    ASSERT_TRUE(shift.has_value()) << moved.transpose();
    EXPECT_LT((shift->shift_px - moved).norm(), 1.5) << moved.transpose();
    EXPECT_NEAR(shift->turn_rad, turn, 0.004);
  }
}

TEST(FindPictureShiftTest, SaysNothingOfPicturesThatAreNotAlike) {
  const HalvedPicture before = HalvePicture(Draw({0, 0}, 0));
  const HalvedPicture dark = HalvePicture(cv::Mat(480, 640, CV_8UC1, cv::Scalar(3)));
  EXPECT_FALSE(FindPictureShift(before, dark).has_value());
  EXPECT_FALSE(FindPictureShift(dark, before).has_value());
  EXPECT_FALSE(FindPictureShift(HalvedPicture(), before).has_value()) << "there was none";
}

}  // namespace
}  // namespace corbslam
