#include "slam/sensor/corner_depth.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>

namespace corbslam {
namespace {

constexpr double kUnitsPerM = 1000;
constexpr int kEdge_px = 50;

Keypoint At(float x_px, uint8_t octave = 0) {
  Keypoint keypoint;
  keypoint.x_px = x_px;
  keypoint.y_px = 40;
  keypoint.octave = octave;
  return keypoint;
}

// Draws something at 2 m on the left in front of a wall at 4 m.
cv::Mat ThingBeforeAWall() {
  cv::Mat depth(80, 100, CV_16UC1, cv::Scalar(4000));
  depth.colRange(0, kEdge_px).setTo(2000);
  return depth;
}

TEST(CornerDepthTest, ACornerBesideAnEdgeHasTheNearerSidesDepth) {
  const cv::Mat depth = ThingBeforeAWall();
  EXPECT_EQ(CornerDepth(depth, At(kEdge_px - 1), kUnitsPerM), 2);
  EXPECT_EQ(CornerDepth(depth, At(kEdge_px), kUnitsPerM), 2);
  EXPECT_EQ(CornerDepth(depth, At(kEdge_px + 1), kUnitsPerM), 2);
  EXPECT_EQ(CornerDepth(depth, At(kEdge_px + 3), kUnitsPerM), 4);
}

TEST(CornerDepthTest, TheReachIsInPixelsOfTheOctave) {
  const cv::Mat depth = ThingBeforeAWall();
  EXPECT_EQ(CornerDepth(depth, At(kEdge_px + 4, 7), kUnitsPerM), 2);
  EXPECT_EQ(CornerDepth(depth, At(kEdge_px + 6, 7), kUnitsPerM), 4);
}

TEST(CornerDepthTest, AShadowOfTheSensorBehindAnEdgeHasTheNearerSidesDepth) {
  cv::Mat metres;
  ThingBeforeAWall().convertTo(metres, CV_32FC1, 1 / kUnitsPerM);
  metres.colRange(kEdge_px, kEdge_px + 1).setTo(std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(CornerDepth(metres, At(kEdge_px), 1), 2);
}

TEST(CornerDepthTest, WhereNothingIsSeenThereIsNoDepth) {
  cv::Mat depth(80, 100, CV_16UC1, cv::Scalar(2000));
  depth.at<uint16_t>(40, 30) = 0;
  EXPECT_EQ(CornerDepth(depth, At(30), kUnitsPerM), 0);
  depth.setTo(0);
  EXPECT_EQ(CornerDepth(depth, At(30), kUnitsPerM), 0);
}

TEST(CornerDepthTest, TheLargestValueOf16BitsIsNoDepth) {
  cv::Mat depth = ThingBeforeAWall();
  depth.colRange(kEdge_px, 100).setTo(65535);
  EXPECT_EQ(CornerDepth(depth, At(kEdge_px + 10), kUnitsPerM), 0);
  EXPECT_EQ(CornerDepth(depth, At(kEdge_px - 1), kUnitsPerM), 2);
}

TEST(CornerDepthTest, ASlantedSurfaceHasNoStep) {
  cv::Mat depth(80, 100, CV_16UC1);
  // The slope is 2 to 4 % a pixel.
  for (int x = 0; x < depth.cols; ++x) depth.col(x).setTo(2000 + 80 * x);
  for (const uint8_t octave : {uint8_t{0}, uint8_t{7}}) {
    EXPECT_EQ(CornerDepth(depth, At(50, octave), kUnitsPerM), 6) << int{octave};
  }
}

TEST(CornerDepthTest, KeypointsAtTheImagesBorderAreRead) {
  const cv::Mat depth = ThingBeforeAWall();
  EXPECT_EQ(CornerDepth(depth, At(0, 7), kUnitsPerM), 2);
  EXPECT_EQ(CornerDepth(depth, At(99.4F, 7), kUnitsPerM), 4);
}

}  // namespace
}  // namespace corbslam
