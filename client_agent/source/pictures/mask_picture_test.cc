#include "client_agent/source/pictures/mask_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace corbslam::client_agent {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string PngOf(const cv::Mat& picture) {
  std::vector<uchar> bytes;
  cv::imencode(".png", picture, bytes);
  return {bytes.begin(), bytes.end()};
}

cv::Mat Mask(int black_rows) {
  cv::Mat mask(100, 64, CV_8UC1, cv::Scalar(255));
  mask.rowRange(0, black_rows).setTo(0);
  return mask;
}

std::string Why(const cv::Mat& picture) {
  return std::string(DecodeMaskPicture("m.png", PngOf(picture)).status().message());
}

TEST(MaskPictureTest, TakesBlackAndWhite) {
  const auto mask = DecodeMaskPicture("m.png", PngOf(Mask(25)));
  ASSERT_TRUE(mask.ok()) << mask.status();
  EXPECT_EQ(MaskedPercent(*mask), 25);
  cv::Mat colour;
  cv::cvtColor(Mask(95), colour, cv::COLOR_GRAY2BGR);
  const auto of_colour = DecodeMaskPicture("m.png", PngOf(colour));
  ASSERT_TRUE(of_colour.ok()) << of_colour.status();
  EXPECT_EQ(of_colour->type(), CV_8UC1);
  EXPECT_EQ(MaskedPercent(*of_colour), 95);
}

TEST(MaskPictureTest, RefusesWhatMayMeanAnything) {
  EXPECT_THAT(Why(Mask(100)), AllOf(StartsWith("m.png: the mask leaves out 100.0 %"),
                                    HasSubstr("is it inverted?")));
  cv::Mat alpha;
  cv::cvtColor(Mask(25), alpha, cv::COLOR_GRAY2BGRA);
  EXPECT_THAT(Why(alpha), HasSubstr("alpha channel"));
  cv::Mat smooth = Mask(25);
  smooth.at<uchar>(25, 3) = 12;
  EXPECT_THAT(Why(smooth), HasSubstr("the value 12 (1 pixels are neither 0 nor 255)"));
  cv::Mat red(100, 64, CV_8UC3, cv::Scalar(0, 0, 255));
  EXPECT_THAT(Why(red), HasSubstr("colours"));
  EXPECT_THAT(Why(cv::Mat(100, 64, CV_16UC1, cv::Scalar(65535))), HasSubstr("a mask of 16 bits"));
}

TEST(MaskPictureTest, ReadsFiles) {
  const std::string path = ::testing::TempDir() + "/mask_picture.png";
  cv::imwrite(path, Mask(10));
  const auto mask = ReadMaskPicture(path);
  ASSERT_TRUE(mask.ok()) << mask.status();
  EXPECT_EQ(MaskedPercent(*mask), 10);
  std::filesystem::resize_file(path, 60);
  EXPECT_THAT(std::string(ReadMaskPicture(path).status().message()), HasSubstr("cut short"));
  std::filesystem::remove(path);
  EXPECT_TRUE(absl::IsNotFound(ReadMaskPicture(path).status()));
}

}  // namespace
}  // namespace corbslam::client_agent
