#include "slam/features/orb_extractor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <random>
#include <set>

#include "slam/features/corner_spread.h"
#include "slam/features/gaussian_blur.h"
#include "slam/features/steered_brief.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;

// Draws overlapping discs and rectangles of random grey, which have corners at every scale.
cv::Mat TexturedImage(int width, int height, uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<uint64_t>(n)); };
  cv::Mat image(height, width, CV_8UC1, cv::Scalar(128));
  for (int i = 0; i < width * height / 300; ++i) {
    const cv::Point at(below(width), below(height));
    const cv::Scalar grey(below(256));
    if (i % 2 == 0) {
      cv::circle(image, at, 2 + below(12), grey, cv::FILLED);
    } else {
      cv::rectangle(image, {at.x, at.y, 3 + below(25), 3 + below(25)}, grey, cv::FILLED);
    }
  }
  cv::GaussianBlur(image, image, {3, 3}, 0.8);
  return image;
}

Features ExtractFrom(const cv::Mat& image, const OrbOptions& options = {}) {
  OrbExtractor extractor(options);
  Features features;
  ImagePyramid pyramid;
  EXPECT_TRUE(extractor.Extract(image, features, pyramid).ok());
  return features;
}

TEST(OrbExtractorTest, GivesTheWantedNumberOverAllOctaves) {
  const Features features = ExtractFrom(TexturedImage(1241, 376, 1));
  EXPECT_EQ(features.keypoints.size(), 2000U);
  EXPECT_EQ(features.descriptors.size(), features.keypoints.size());
  std::set<int> octaves;
  for (const Keypoint& keypoint : features.keypoints) octaves.insert(keypoint.octave);
  EXPECT_EQ(octaves.size(), static_cast<size_t>(ScalePyramid::kLevels));
}

TEST(OrbExtractorTest, TheSameImageGivesTheSameFeatures) {
  const cv::Mat image = TexturedImage(640, 480, 2);
  OrbExtractor extractor({});
  Features first, second;
  ImagePyramid pyramid;
  ASSERT_TRUE(extractor.Extract(image, first, pyramid).ok());
  // Buffers that another image has filled must not show through.
  ASSERT_TRUE(extractor.Extract(TexturedImage(640, 480, 3), second, pyramid).ok());
  ASSERT_TRUE(extractor.Extract(image, second, pyramid).ok());
  EXPECT_EQ(first.keypoints, second.keypoints);
  EXPECT_EQ(first.descriptors, second.descriptors);
}

TEST(OrbExtractorTest, CoversEveryPartOfATexturedImage) {
  const Features features = ExtractFrom(TexturedImage(640, 480, 4), {.features = 1000});
  int counts[4][4] = {};
  for (const Keypoint& keypoint : features.keypoints) {
    ++counts[static_cast<int>(keypoint.y_px / 120)][static_cast<int>(keypoint.x_px / 160)];
  }
  for (const auto& row : counts) {
    for (const int count : row) EXPECT_GE(count, 30);  // An even spread has 62 in each.
  }
}

TEST(OrbExtractorTest, FindsFaintCornersWhereThereAreNoStrongOnes) {
  cv::Mat image = TexturedImage(640, 480, 5);
  cv::Mat right_half = image.colRange(320, 640);
  right_half.convertTo(right_half, CV_8UC1, 0.08, 100);
  const Features features = ExtractFrom(image, {.features = 1000});
  EXPECT_GT(std::ranges::count_if(features.keypoints, [](const auto& k) { return k.x_px > 340; }),
            50);
  const Features strict = ExtractFrom(image, {.features = 1000, .min_fast_threshold = 20});
  EXPECT_EQ(std::ranges::count_if(strict.keypoints, [](const auto& k) { return k.x_px > 340; }), 0);
}

TEST(OrbExtractorTest, DescriptorsFollowTheTurnOfTheImage) {
  const cv::Mat image = TexturedImage(480, 480, 6);
  const Features features = ExtractFrom(image, {.features = 800});
  for (const double degrees : {30.0, 90.0, 200.0}) {
    const cv::Mat turn = cv::getRotationMatrix2D({239.5F, 239.5F}, degrees, 1);
    cv::Mat turned_image;
    cv::warpAffine(image, turned_image, turn, image.size());
    const Features turned = ExtractFrom(turned_image, {.features = 800});
    const cv::Matx23d m(turn);
    std::vector<int> distances;
    for (size_t i = 0; i < features.keypoints.size(); ++i) {
      const Keypoint& a = features.keypoints[i];
      const cv::Vec2d expected = m * cv::Vec3d(a.x_px, a.y_px, 1);
      for (size_t j = 0; j < turned.keypoints.size(); ++j) {
        const Keypoint& b = turned.keypoints[j];
        if (a.octave != b.octave) continue;
        if (std::hypot(b.x_px - expected[0], b.y_px - expected[1]) > 1) continue;
        distances.push_back(HammingDistance(features.descriptors[i], turned.descriptors[j]));
      }
    }
    ASSERT_GT(distances.size(), 100U) << degrees;
    std::ranges::sort(distances);
    EXPECT_LT(distances[distances.size() / 2], 45) << degrees;  // Unrelated ones differ by 128.
  }
}

TEST(OrbExtractorTest, DescriptorsOfUnrelatedCornersDiffer) {
  const Features features = ExtractFrom(TexturedImage(640, 480, 7));
  double sum = 0;
  for (size_t i = 0; i + 7 < 1000; ++i) {
    sum += HammingDistance(features.descriptors[i], features.descriptors[i + 7]);
  }
  EXPECT_GT(sum / 993, 95);
}

TEST(SteeredBriefTest, DescribesByTheDefinition) {
  cv::Mat image = TexturedImage(64, 64, 9);
  const BriefPattern& pattern = LearnedBriefPattern();
  const SteeredBrief brief(pattern);
  for (int step = -100; step < 100; step += 7) {
    const double angle = 2 * std::numbers::pi * step / SteeredBrief::kAngles;
    const auto grey = [&](int x, int y) {
      return image.at<uint8_t>(
          32 + static_cast<int>(std::lround(std::sin(angle) * x + std::cos(angle) * y)),
          31 + static_cast<int>(std::lround(std::cos(angle) * x - std::sin(angle) * y)));
    };
    const Descriptor descriptor = brief.Describe(image, 31, 32, static_cast<float>(angle));
    for (size_t t = 0; t < pattern.size(); ++t) {
      const bool is_set = (descriptor.words[t / 64] >> (t % 64) & 1) != 0;
      ASSERT_EQ(is_set, grey(pattern[t].x1, pattern[t].y1) < grey(pattern[t].x2, pattern[t].y2))
          << step << " " << t;
    }
  }
}

TEST(ImagePyramidTest, PositionsOfAllOctavesAreThoseOfTheImage) {
  // The centre of one soft blob, measured in every level, is the same place of the image.
  cv::Mat image(376, 1241, CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const double distance2 = std::pow(x - 900.25, 2) + std::pow(y - 150.5, 2);
      image.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(250 * std::exp(-distance2 / 400));
    }
  }
  ImagePyramid pyramid;
  BuildImagePyramid(image, pyramid);
  for (int octave = 0; octave < ScalePyramid::kLevels; ++octave) {
    const cv::Moments moments = cv::moments(pyramid.levels[static_cast<size_t>(octave)]);
    const float x = static_cast<float>(moments.m10 / moments.m00);
    const float y = static_cast<float>(moments.m01 / moments.m00);
    EXPECT_NEAR(pyramid.ToLevel0X(x, octave), 900.25, 0.1) << octave;
    EXPECT_NEAR(pyramid.ToLevel0Y(y, octave), 150.5, 0.1) << octave;
    EXPECT_NEAR(pyramid.FromLevel0X(pyramid.ToLevel0X(x, octave), octave), x, 1e-3);
  }
}

TEST(OrbExtractorTest, RefusesColourAndTinyImages) {
  OrbExtractor extractor({});
  Features features;
  ImagePyramid pyramid;
  EXPECT_THAT(extractor.Extract(cv::Mat::zeros(480, 640, CV_8UC3), features, pyramid).message(),
              HasSubstr("3 channels"));
  EXPECT_THAT(extractor.Extract(cv::Mat::zeros(20, 640, CV_8UC1), features, pyramid).message(),
              HasSubstr("640x20"));
}

TEST(OrbExtractorTest, AFlatImageHasNoFeatures) {
  EXPECT_TRUE(ExtractFrom(cv::Mat(100, 100, CV_8UC1, cv::Scalar(90))).keypoints.empty());
}

TEST(OrbOptionsTest, ValidateNamesTheField) {
  EXPECT_TRUE(OrbOptions{}.Validate().ok());
  EXPECT_THAT(OrbOptions{.features = 3}.Validate().message(), HasSubstr("features is 3"));
  EXPECT_THAT(OrbOptions{.min_fast_threshold = 30}.Validate().message(),
              HasSubstr("min_fast_threshold is 30"));
}

TEST(CornerSpreadTest, KeepsTheStrongestOfEachCrowd) {
  std::vector<Corner> corners;
  for (int16_t i = 0; i < 50; ++i) corners.push_back({i, 3, static_cast<uint8_t>(i + 10)});
  corners.push_back({190, 90, 8});
  SpreadCorners(200, 100, 2, corners);
  ASSERT_EQ(corners.size(), 2U);
  EXPECT_EQ(corners[0], (Corner{49, 3, 59}));
  EXPECT_EQ(corners[1], (Corner{190, 90, 8}));
}

TEST(GaussianBlurTest, AgreesWithOpenCvToRounding) {
  const cv::Mat image = TexturedImage(131, 77, 8);
  cv::Mat ours, theirs;
  BlurGaussian7x7(image, ours);
  cv::GaussianBlur(image, theirs, {7, 7}, 2, 2, cv::BORDER_REFLECT_101);
  EXPECT_LE(cv::norm(ours, theirs, cv::NORM_INF), 3);
}

}  // namespace
}  // namespace corbslam
