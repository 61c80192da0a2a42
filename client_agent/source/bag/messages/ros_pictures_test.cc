#include "client_agent/source/bag/messages/ros_pictures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <tuple>
#include <vector>

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

RosImage ImageOf(const std::string& encoding, uint32_t width_px, uint32_t height_px, uint32_t step,
                 const std::string& data) {
  RosImage image;
  image.encoding = encoding;
  image.width_px = width_px;
  image.height_px = height_px;
  image.step = step;
  image.data = data;
  return image;
}

TEST(RosPicturesTest, GreyOfEachEncoding) {
  // A grey of 100, however it is written.
  const std::string grey = std::string(64, 100);
  const std::string alpha = [] {
    std::string pixels;
    for (int i = 0; i < 16; ++i) pixels += std::string(3, 100) + '\xff';
    return pixels;
  }();
  std::string uyvy;
  std::string yuyv;
  for (int i = 0; i < 16; ++i) {
    uyvy += std::string{'\x80', 100};
    yuyv += std::string{100, '\x80'};
  }
  const std::string rgb(48, 100);
  for (const auto& [encoding, step, data] : {std::tuple("mono8", 4u, grey),
                                             {"8UC1", 4u, grey},
                                             {"rgb8", 12u, rgb},
                                             {"bgr8", 12u, rgb},
                                             {"rgba8", 16u, alpha},
                                             {"bgra8", 16u, alpha},
                                             {"bayer_rggb8", 4u, grey},
                                             {"bayer_bggr8", 4u, grey},
                                             {"bayer_gbrg8", 4u, grey},
                                             {"bayer_grbg8", 4u, grey},
                                             {"yuv422", 8u, uyvy},
                                             {"yuv422_yuy2", 8u, yuyv},
                                             {"yuyv", 8u, yuyv},
                                             {"nv12", 4u, grey}}) {
    const std::string pixels = data;
    const auto picture = GreyOf(ImageOf(encoding, 4, 4, step, pixels));
    ASSERT_TRUE(picture.ok()) << encoding << picture.status();
    ASSERT_EQ(picture->type(), CV_8UC1) << encoding;
    EXPECT_EQ(cv::countNonZero(*picture != 100), 0) << encoding;
  }
}

TEST(RosPicturesTest, ColoursAreInTheirOrder) {
  const std::string red = std::string{'\xff', 0, 0, '\xff', 0, 0};
  EXPECT_EQ(GreyOf(ImageOf("rgb8", 2, 1, 6, red))->at<uint8_t>(0, 0), 76);
  EXPECT_EQ(GreyOf(ImageOf("bgr8", 2, 1, 6, red))->at<uint8_t>(0, 0), 29);
  // A red sensor pixel at the corner of each pattern's first two rows.
  std::string pattern(64, 0);
  for (size_t y = 0; y < 8; y += 2) {
    for (size_t x = 0; x < 8; x += 2) pattern[8 * y + x] = '\xff';
  }
  EXPECT_EQ(GreyOf(ImageOf("bayer_rggb8", 8, 8, 8, pattern))->at<uint8_t>(4, 4), 76);
  EXPECT_EQ(GreyOf(ImageOf("bayer_bggr8", 8, 8, 8, pattern))->at<uint8_t>(4, 4), 29);
}

TEST(RosPicturesTest, RowsMayBePaddedAndBytesTurned) {
  const std::string padded = {1, 2, 9, 9, 3, 4};  // The last row ends with its pixels.
  const auto grey = GreyOf(ImageOf("mono8", 2, 2, 4, padded));
  ASSERT_TRUE(grey.ok()) << grey.status();
  EXPECT_EQ(grey->at<uint8_t>(1, 1), 4);
  const std::string big = {1, 2, 3, 4};
  RosImage image = ImageOf("16UC1", 2, 1, 4, big);
  EXPECT_EQ(DepthOf(image)->at<uint16_t>(0, 0), 0x0201);
  image.is_big_endian = true;
  EXPECT_EQ(DepthOf(image)->at<uint16_t>(0, 0), 0x0102);
}

TEST(RosPicturesTest, WhatCantBeIsRefused) {
  const std::string data(16, 0);
  const auto refusal = [&](const RosImage& image) {
    return std::string(GreyOf(image).status().message());
  };
  EXPECT_THAT(refusal(ImageOf("mono8", 4, 5, 4, data)), HasSubstr("data has 16 bytes"));
  EXPECT_THAT(refusal(ImageOf("mono8", 4, 4, 3, data)), HasSubstr("step is 3"));
  EXPECT_THAT(refusal(ImageOf("mono8", 0, 4, 4, data)), HasSubstr("width, height are 0, 4"));
  EXPECT_THAT(refusal(ImageOf("mono8", UINT32_MAX, UINT32_MAX, UINT32_MAX, data)),
              HasSubstr("must be 1 to"));
  EXPECT_THAT(refusal(ImageOf("64FC1", 1, 1, 8, data)), HasSubstr("encoding is '64FC1'"));
  EXPECT_THAT(DepthOf(ImageOf("rgb8", 1, 1, 3, data)).status().message(), HasSubstr("32FC1"));
}

std::string EncodedBytes(const cv::Mat& picture, const char* ending) {
  std::vector<uint8_t> bytes;
  cv::imencode(ending, picture, bytes);
  return {bytes.begin(), bytes.end()};
}

RosCompressedImage CompressedOf(const std::string& format, const std::string& data) {
  RosCompressedImage image;
  image.format = format;
  image.data = data;
  return image;
}

TEST(RosPicturesTest, CompressedPicturesAreDecoded) {
  const cv::Mat grey(30, 40, CV_8UC1, cv::Scalar(90));
  for (const char* ending : {".png", ".jpg"}) {
    const std::string data = EncodedBytes(grey, ending);
    const auto decoded = GreyOf(CompressedOf("mono8; compressed", data));
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    EXPECT_LE(cv::norm(*decoded, grey, cv::NORM_INF), 1);
    const std::string cut = data.substr(0, data.size() / 2);
    EXPECT_FALSE(GreyOf(CompressedOf("jpeg", cut)).ok());
  }
  EXPECT_TRUE(FormOf(CompressedOf("jpeg", EncodedBytes(grey, ".jpg"))).can_be_grey);
  EXPECT_FALSE(FormOf(CompressedOf("h264", "....")).can_be_grey);
}

std::string PackHead(float a, float b) {
  std::string head(12, 0);
  std::memcpy(head.data() + 4, &a, 4);
  std::memcpy(head.data() + 8, &b, 4);
  return head;
}

TEST(RosPicturesTest, CompressedDepthIsUnpacked) {
  const cv::Mat depth = (cv::Mat_<uint16_t>(2, 3) << 0, 0, 500, 499, 0, 65535);
  const std::string png = PackHead(0, 0) + EncodedBytes(depth, ".png");
  const auto raw = DepthOf(CompressedOf("16UC1; compressedDepth png", png));
  ASSERT_TRUE(raw.ok()) << raw.status();
  EXPECT_EQ(cv::norm(*raw, depth, cv::NORM_INF), 0);
  const std::string packed = PackHead(1000, 100) + EncodedBytes(depth, ".png");
  const auto metres = DepthOf(CompressedOf("32FC1; compressedDepth", packed));
  ASSERT_TRUE(metres.ok()) << metres.status();
  ASSERT_EQ(metres->type(), CV_32FC1);
  EXPECT_TRUE(std::isnan(metres->at<float>(0, 0)));
  EXPECT_FLOAT_EQ(metres->at<float>(0, 2), 2.5f);
  EXPECT_FALSE(DepthOf(CompressedOf("16UC1; compressedDepth png", "short")).ok());
}

// Writes numbers as RVL does: groups of three bits, the lowest first, eight groups a word.
std::string RvlBytes(uint32_t width_px, uint32_t height_px, const std::vector<uint32_t>& numbers) {
  std::vector<uint32_t> groups;
  for (uint32_t number : numbers) {
    do {
      const uint32_t rest = number >> 3;
      groups.push_back((number & 7) | (rest != 0 ? 8 : 0));
      number = rest;
    } while (number != 0);
  }
  while (groups.size() % 8 != 0) groups.push_back(0);
  std::vector<uint32_t> words = {width_px, height_px};
  for (size_t i = 0; i < groups.size(); i += 8) {
    uint32_t word = 0;
    for (size_t k = 0; k < 8; ++k) word = word << 4 | groups[i + k];
    words.push_back(word);
  }
  return {reinterpret_cast<const char*>(words.data()), 4 * words.size()};
}

TEST(RosPicturesTest, RvlIsUnpacked) {
  // Two zeros, then 500 and 499 (differences 500, -1), a zero, 65535 (difference of 65036).
  const std::string data = PackHead(0, 0) + RvlBytes(3, 2, {2, 2, 1000, 1, 1, 1, 2 * 65036});
  const auto depth = DepthOf(CompressedOf("16UC1; compressedDepth rvl", data));
  ASSERT_TRUE(depth.ok()) << depth.status();
  const cv::Mat expected = (cv::Mat_<uint16_t>(2, 3) << 0, 0, 500, 499, 0, 65535);
  EXPECT_EQ(cv::norm(*depth, expected, cv::NORM_INF), 0);
  for (const auto& numbers : {std::vector<uint32_t>{9, 1}, {2, 9}, {0, 0}, {2, 2}}) {
    const std::string bad = PackHead(0, 0) + RvlBytes(3, 2, numbers);
    EXPECT_FALSE(DepthOf(CompressedOf("16UC1; compressedDepth rvl", bad)).ok());
  }
  const std::string huge = PackHead(0, 0) + RvlBytes(UINT32_MAX, 2, {});
  EXPECT_FALSE(DepthOf(CompressedOf("16UC1; compressedDepth rvl", huge)).ok());
}

}  // namespace
}  // namespace corbslam::client_agent
