#include "services/simulation/obstructions.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace corbslam {
namespace {

// Columns that are bright and dark in turn.
cv::Mat Stripes() {
  cv::Mat light(60, 80, CV_32FC1, cv::Scalar(0.2));
  for (int x = 0; x < light.cols; x += 2) light.col(x).setTo(1.0);
  return light;
}

// Returns the share of pixels that are as they were.
double Untouched(const cv::Mat& light) {
  return 1 - static_cast<double>(cv::countNonZero(light != Stripes())) /
                 static_cast<double>(light.total());
}

double Contrast(const cv::Mat& light) {
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(light, mean, deviation);
  return deviation[0];
}

TEST(ObstructionsTest, AHandHidesTheShareThatItCovers) {
  cv::Mat light = Stripes();
  CoverByHand(0, light);
  EXPECT_EQ(Untouched(light), 1);
  CoverByHand(0.5, light);
  EXPECT_GT(Untouched(light), 0.35);
  EXPECT_LT(Untouched(light), 0.65);
  EXPECT_EQ(cv::norm(light.colRange(0, 20), Stripes().colRange(0, 20), cv::NORM_INF), 0)
      << "it comes from the right";
  CoverByHand(1, light);
  EXPECT_EQ(Untouched(light), 0);
  EXPECT_LT(Contrast(light), 0.05);
  EXPECT_GT(cv::mean(light)[0], 0.05);
}

TEST(ObstructionsTest, ALensOutOfFocusLosesWhatIsFine) {
  cv::Mat light = Stripes();
  Defocus(0, light);
  EXPECT_EQ(Untouched(light), 1);
  Defocus(4, light);
  // At its sides the picture is continued by its last column.
  const cv::Mat inner = light.colRange(16, 64);
  EXPECT_LT(Contrast(inner), 0.02);
  EXPECT_NEAR(cv::mean(inner)[0], 0.6, 0.01);
}

}  // namespace
}  // namespace corbslam
