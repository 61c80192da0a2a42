#include "client_agent/agent/picture_encoder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "slam/exchange/uplink.h"

namespace corbslam::client_agent {
namespace {

StereoCalibration Rectified(int width, int height) {
  StereoCalibration stereo;
  stereo.camera = {.fx_px = 400,
                   .fy_px = 400,
                   .cx_px = width / 2.0,
                   .cy_px = height / 2.0,
                   .width_px = width,
                   .height_px = height,
                   .baseline_m = 0.2,
                   .close_depth_m = 8};
  return stereo;
}

cv::Mat Decode(const PictureEncoder::Encoded& encoded) {
  const std::vector<uchar> bytes(encoded.jpeg.begin(), encoded.jpeg.end());
  return cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
}

cv::Mat Noise(int width, int height) {
  cv::Mat noise(height, width, CV_8UC1);
  cv::RNG(7).fill(noise, cv::RNG::UNIFORM, 0, 256);
  return noise;
}

TEST(PictureEncoderTest, PicturesOfAnyFormHaveAboutAsManyPixels) {
  for (const auto& [width, height] : {std::pair(1241, 376), {640, 480}, {480, 640}, {752, 480}}) {
    const auto encoder = PictureEncoder::Make(Rectified(width, height), 320);
    ASSERT_TRUE(encoder.ok()) << encoder.status();
    const auto encoded = encoder->Encode(cv::Mat(height, width, CV_8UC1, cv::Scalar(90)));
    ASSERT_TRUE(encoded.ok()) << encoded.status();
    const cv::Mat picture = Decode(*encoded);
    ASSERT_FALSE(picture.empty());
    EXPECT_EQ(picture.channels(), 1);
    EXPECT_NEAR(picture.cols * picture.rows, 320 * 240, 1500);
    EXPECT_NEAR(picture.cols * encoded->scale, width, 1e-6);
    EXPECT_NEAR(picture.rows * encoded->scale, height, encoded->scale);
  }
}

TEST(PictureEncoderTest, ASmallPictureIsNotMadeLarger) {
  const auto encoded = PictureEncoder::Make(Rectified(160, 120), 320)
                           ->Encode(cv::Mat(120, 160, CV_8UC1, cv::Scalar(90)));
  ASSERT_TRUE(encoded.ok());
  EXPECT_EQ(encoded->scale, 1);
  EXPECT_EQ(Decode(*encoded).cols, 160);
}

// What is hardest to encode keeps to the limit, at the largest size that can be asked for.
TEST(PictureEncoderTest, NoiseKeepsToTheLimitOrIsNotSent) {
  const auto small = PictureEncoder::Make(Rectified(640, 480), 320)->Encode(Noise(640, 480));
  ASSERT_TRUE(small.ok()) << small.status();
  EXPECT_LE(small->jpeg.size(), kMaxPictureBytes);
  const auto large = PictureEncoder::Make(Rectified(1280, 960), 1280)->Encode(Noise(1280, 960));
  EXPECT_TRUE(!large.ok() || large->jpeg.size() <= kMaxPictureBytes);
}

// A bright spot lies where the keypoint of it lies, by the scale that is told.
TEST(PictureEncoderTest, WhatLiesAtAKeypointLiesThereInThePicture) {
  cv::Mat grey(376, 1241, CV_8UC1, cv::Scalar(20));
  cv::circle(grey, {1000, 150}, 12, cv::Scalar(250), cv::FILLED);
  const auto encoded = PictureEncoder::Make(Rectified(1241, 376), 320)->Encode(grey);
  ASSERT_TRUE(encoded.ok());
  cv::Mat bright = Decode(*encoded) > 128;
  const cv::Moments moments = cv::moments(bright, /*binaryImage=*/true);
  EXPECT_NEAR(moments.m10 / moments.m00, 1000.5 / encoded->scale - 0.5, 0.3);
  EXPECT_NEAR(moments.m01 / moments.m00, 150.5 / encoded->scale - 0.5, 0.3);
}

TEST(PictureEncoderTest, ALensIsTakenOutAsItIsOfKeypoints) {
  RgbdCalibration rgbd;
  rgbd.camera = {.fx_px = 500,
                 .fy_px = 500,
                 .cx_px = 320,
                 .cy_px = 240,
                 .width_px = 640,
                 .height_px = 480,
                 .baseline_m = 0.08,
                 .close_depth_m = 4};
  rgbd.lens = RadialTangential{-0.3, 0.1, 0, 0, 0};
  const Eigen::Vector2d seen(560, 100);
  cv::Mat grey(480, 640, CV_8UC1, cv::Scalar(20));
  cv::circle(grey, {560, 100}, 8, cv::Scalar(250), cv::FILLED);
  const auto encoder = PictureEncoder::Make(rgbd, 320);
  ASSERT_TRUE(encoder.ok()) << encoder.status();
  const auto encoded = encoder->Encode(grey);
  ASSERT_TRUE(encoded.ok()) << encoded.status();
  const Eigen::Vector2d keypoint = *UndistortPixel(rgbd.camera, rgbd.lens, seen);
  ASSERT_GT((keypoint - seen).norm(), 10);
  cv::Mat bright = Decode(*encoded) > 128;
  const cv::Moments moments = cv::moments(bright, /*binaryImage=*/true);
  ASSERT_GT(moments.m00, 0);
  EXPECT_NEAR(moments.m10 / moments.m00, (keypoint.x() + 0.5) / encoded->scale - 0.5, 0.7);
  EXPECT_NEAR(moments.m01 / moments.m00, (keypoint.y() + 0.5) / encoded->scale - 0.5, 0.7);
}

}  // namespace
}  // namespace corbslam::client_agent
