#include "slam/sensor/patch_alignment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

namespace corbslam {
namespace {

constexpr int kSide_px = 64;
constexpr int kMiddle_px = kSide_px / 2;

// Makes smooth noise, the same for the same seed.
cv::Mat Texture(uint64_t seed) {
  std::mt19937_64 random(seed);
  cv::Mat noise(kSide_px, kSide_px, CV_32FC1);
  for (float& value : cv::Mat_<float>(noise)) value = static_cast<float>(random() % 256);
  cv::GaussianBlur(noise, noise, {}, 1.5);
  return (noise - 128) * 3 + 128;
}

cv::Mat Shifted(const cv::Mat& texture, double left_px, double up_px = 0) {
  const cv::Matx23d move(1, 0, -left_px, 0, 1, -up_px);
  cv::Mat shifted;
  cv::warpAffine(texture, shifted, move, texture.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT);
  return shifted;
}

cv::Mat Grey(const cv::Mat& picture) {
  cv::Mat grey;
  picture.convertTo(grey, CV_8UC1);
  return grey;
}

TEST(PatchAlignmentTest, FindsAShiftOfPartsOfAPixel) {
  for (const double shift_px : {0.0, 0.3, 1.5, -2.25, 3.9}) {
    const cv::Mat left = Texture(1);
    const auto found =
        AlignPatch(Grey(left), Grey(Shifted(left, shift_px)), kMiddle_px, kMiddle_px, kMiddle_px);
    ASSERT_TRUE(found.has_value()) << shift_px;
    EXPECT_NEAR(kMiddle_px - found->right_x_px, shift_px, 0.05) << shift_px;
  }
}

// Structure along a slope turns a shift of rows into one of columns, unless both are looked for.
TEST(PatchAlignmentTest, RowsThatAreOffByPartsOfAPixelDoNotMoveColumns) {
  constexpr double kShift_px = 1.3;
  constexpr double kRows_px = 0.4;
  std::vector<double> errors;
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    const cv::Mat left = Texture(seed);
    const cv::Mat right = Shifted(left, kShift_px, kRows_px);
    const auto found = AlignPatch(Grey(left), Grey(right), kMiddle_px, kMiddle_px, kMiddle_px);
    ASSERT_TRUE(found.has_value()) << seed;
    errors.push_back(std::abs(kMiddle_px - found->right_x_px - kShift_px));
  }
  std::ranges::sort(errors);
  // Errors are 0.08 and 0.25 if columns alone are looked for.
  EXPECT_LT(errors[errors.size() / 2], 0.05);
  EXPECT_LT(errors[errors.size() * 9 / 10], 0.1);
}

TEST(PatchAlignmentTest, PatchesAtTheBorderAreFound) {
  constexpr double kShift_px = 0.3;
  const cv::Mat left = Texture(1);
  const cv::Mat right = Shifted(left, kShift_px);
  for (const int y : {5, kSide_px - 6}) {
    for (const int x : {10, kSide_px - 11}) {
      const auto found = AlignPatch(Grey(left), Grey(right), x, y, x);
      ASSERT_TRUE(found.has_value()) << x << " " << y;
      EXPECT_NEAR(double{found->right_x_px}, x - kShift_px, 0.1) << x << " " << y;
    }
  }
}

TEST(PatchAlignmentTest, PicturesOfDifferentExposureAlignTheSame) {
  const cv::Mat left = Texture(1);
  const cv::Mat right = Shifted(left, 1.5) + 30;
  const auto found = AlignPatch(Grey(left), Grey(right), kMiddle_px, kMiddle_px, kMiddle_px);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(kMiddle_px - found->right_x_px, 1.5, 0.05);
}

// The upper left of the patch is nearer and is shifted by more than what is behind it.
TEST(PatchAlignmentTest, ACornersOwnSurfaceCountsMoreThanWhatIsBehindIt) {
  constexpr double kNear_px = 2.5;
  constexpr double kFar_px = 1;
  constexpr double kEdge_px = kMiddle_px + 3;
  std::vector<double> errors;
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    const cv::Mat behind = Texture(2 * seed);
    const cv::Mat before = Texture(2 * seed + 1);
    cv::Mat is_near(kSide_px, kSide_px, CV_32FC1, cv::Scalar(0));
    is_near(cv::Rect(0, 0, static_cast<int>(kEdge_px), static_cast<int>(kEdge_px))).setTo(1);
    const auto draw = [&](double near_px, double far_px) {
      const cv::Mat mask = Shifted(is_near, near_px);
      return Grey(Shifted(before, near_px).mul(mask) + Shifted(behind, far_px).mul(1 - mask));
    };
    const auto found =
        AlignPatch(draw(0, 0), draw(kNear_px, kFar_px), kMiddle_px, kMiddle_px, kMiddle_px - 2);
    if (found.has_value()) errors.push_back(std::abs(kMiddle_px - found->right_x_px - kNear_px));
  }
  ASSERT_GT(errors.size(), 150U);
  std::ranges::sort(errors);
  // Errors are 0.21 and 0.53 if pixels count whether the shift explains them or not.
  EXPECT_LT(errors[errors.size() / 2], 0.1);
  EXPECT_LT(errors[errors.size() * 3 / 4], 0.3);
}

TEST(PatchAlignmentTest, FlatPatchesAndThoseBeyondTheImageAreNotFound) {
  const cv::Mat left = Texture(1);
  const cv::Mat flat(kSide_px, kSide_px, CV_8UC1, cv::Scalar(100));
  const auto align = [&](const cv::Mat& right, int left_x) {
    return AlignPatch(Grey(left), right, left_x, kMiddle_px, kMiddle_px);
  };
  EXPECT_FALSE(align(flat, kMiddle_px).has_value());
  EXPECT_FALSE(align(Grey(left), 4).has_value());  // The patch leaves the image.
}

}  // namespace
}  // namespace corbslam
