#include "slam/sensor/picture_features.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "slam/sensor/picture_header.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;

cv::Mat Checks(int width, int height) {
  cv::Mat picture(height, width, CV_8UC1);
  cv::RNG random(5);
  for (int y = 0; y < height; y += 16) {
    for (int x = 0; x < width; x += 16) {
      const cv::Rect cell(x, y, std::min(16, width - x), std::min(16, height - y));
      picture(cell).setTo(random.uniform(0, 256));
    }
  }
  return picture;
}

std::string Encode(const cv::Mat& picture, const char* extension) {
  std::vector<uint8_t> bytes;
  EXPECT_TRUE(cv::imencode(extension, picture, bytes));
  return {bytes.begin(), bytes.end()};
}

std::string ErrorOf(const std::string& encoded) {
  return std::string(DecodePicture(encoded).status().message());
}

const RawCamera kPinhole = {.fx_px = 300, .fy_px = 300, .cx_px = 160, .cy_px = 120, .lens = {}};

TEST(PictureFeaturesTest, ReadsGreyAndColour) {
  const cv::Mat grey = Checks(320, 240);
  cv::Mat colour;
  cv::cvtColor(grey, colour, cv::COLOR_GRAY2BGR);
  for (const auto& encoded : {Encode(grey, ".png"), Encode(colour, ".png")}) {
    const auto decoded = DecodePicture(encoded);
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    EXPECT_EQ(cv::norm(*decoded, grey, cv::NORM_INF), 0);
  }
  for (const auto& encoded : {Encode(grey, ".jpg"), Encode(colour, ".jpg")}) {
    ASSERT_TRUE(DecodePicture(encoded).ok());
    EXPECT_EQ(PictureSize(encoded)->width, 320);
    EXPECT_EQ(PictureSize(encoded)->height, 240);
  }
}

// 16 bits, of which a camera uses 8, 10, 12 or all.
TEST(PictureFeaturesTest, TakesTheBitsThatAreUsed) {
  const cv::Mat grey = Checks(320, 240);
  for (const int factor : {1, 4, 16, 256}) {
    cv::Mat sixteen;
    grey.convertTo(sixteen, CV_16UC1, factor);
    const auto decoded = DecodePicture(Encode(sixteen, ".png"));
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    EXPECT_LE(cv::norm(*decoded, grey, cv::NORM_INF), 1) << factor;
  }
}

TEST(PictureFeaturesTest, RefusesWhatIsNoPicture) {
  EXPECT_THAT(ErrorOf(""), HasSubstr("0 bytes"));
  EXPECT_THAT(ErrorOf("GIF89a and so on"), HasSubstr("neither a PNG nor a JPEG"));
  EXPECT_THAT(ErrorOf(std::string(kMaxEncodedBytes + 1, 'x')), HasSubstr("must have 1 to 3145728"));
  EXPECT_THAT(ErrorOf(Encode(Checks(320, 60), ".png")), HasSubstr("320x60"));
  for (const char* extension : {".png", ".jpg"}) {
    const std::string whole = Encode(Checks(320, 240), extension);
    EXPECT_THAT(ErrorOf(whole.substr(0, whole.size() / 2)), HasSubstr("cut short")) << extension;
    EXPECT_THAT(ErrorOf(whole.substr(0, 12)), HasSubstr("header is damaged")) << extension;
  }
}

// A file of a few bytes may claim to be of any size.
TEST(PictureFeaturesTest, DoesNotDecodeWhatClaimsTooMuch) {
  std::string png = Encode(Checks(320, 240), ".png");
  png[16] = '\x01';  // The highest byte of the width.
  EXPECT_THAT(ErrorOf(png), HasSubstr("16777536x240"));
}

TEST(PictureFeaturesTest, EveryByteOfAFileMayBeDamaged) {
  for (const char* extension : {".png", ".jpg"}) {
    const std::string whole = Encode(Checks(80, 64), extension);
    for (size_t i = 0; i < whole.size(); i += 3) {
      std::string damaged = whole;
      damaged[i] = static_cast<char>(damaged[i] ^ 0x55);
      const auto decoded = DecodePicture(damaged);  // Whatever it says, it says it.
      if (decoded.ok()) {
        EXPECT_EQ(decoded->type(), CV_8UC1);
      }
    }
  }
}

TEST(PictureFeaturesTest, FindsFeaturesInThePinholesPixels) {
  const cv::Mat picture = Checks(320, 240);
  const auto ideal = FindPictureFeatures(picture, kPinhole, 500);
  ASSERT_TRUE(ideal.ok()) << ideal.status();
  EXPECT_GT(ideal->features.keypoints.size(), 200u);
  EXPECT_EQ(ideal->features.keypoints.size(), ideal->features.descriptors.size());
  EXPECT_EQ(ideal->camera.width_px, 320);
  EXPECT_FALSE(ideal->camera.IsMetric());

  RawCamera barrel = kPinhole;
  barrel.lens = RadialTangential{.k1 = -0.2};
  const auto moved = FindPictureFeatures(picture, barrel, 500);
  ASSERT_TRUE(moved.ok()) << moved.status();
  ASSERT_EQ(moved->features.keypoints.size(), ideal->features.keypoints.size());
  for (size_t i = 0; i < moved->features.keypoints.size(); ++i) {
    const Eigen::Vector2d raw = ideal->features.keypoints[i].Pixel();
    const Eigen::Vector2d pinhole = moved->features.keypoints[i].Pixel();
    const Eigen::Vector3d ray = Unproject(moved->camera, pinhole.x(), pinhole.y(), 1);
    EXPECT_LT((*ProjectRaw(barrel, ray) - raw).norm(), 0.01);
  }
}

TEST(PictureFeaturesTest, AFisheyesEdgesAreLeftOut) {
  RawCamera fisheye = {.fx_px = 70, .fy_px = 70, .cx_px = 160, .cy_px = 120, .lens = Equidistant{}};
  const auto found = FindPictureFeatures(Checks(320, 240), fisheye, 500);
  ASSERT_TRUE(found.ok()) << found.status();
  const auto all = FindPictureFeatures(Checks(320, 240), kPinhole, 500);
  EXPECT_LT(found->features.keypoints.size(), all->features.keypoints.size());
  EXPECT_GT(found->features.keypoints.size(), 50u);
  for (const Keypoint& keypoint : found->features.keypoints) {
    EXPECT_GE(keypoint.x_px, -320);
    EXPECT_LE(keypoint.x_px, 640);
  }
}

TEST(PictureFeaturesTest, NamesWhatIsWrongWithTheCamera) {
  RawCamera camera = kPinhole;
  camera.fx_px = 0;
  EXPECT_THAT(std::string(FindPictureFeatures(Checks(320, 240), camera, 500).status().message()),
              HasSubstr("fx"));
  EXPECT_THAT(std::string(FindPictureFeatures(Checks(320, 240), kPinhole, 5).status().message()),
              HasSubstr("features is 5"));
}

}  // namespace
}  // namespace corbslam
