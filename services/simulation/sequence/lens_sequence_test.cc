// Sequences through the lenses of a rig: pairs that are not rectified, fisheyes, and what happens
// to their pictures.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "services/simulation/sequence/simulated_sequence.h"
#include "slam/camera/rectification.h"

namespace corbslam {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 400;

// A pair whose right camera is turned by 2.6 degrees and has other intrinsics.
SimulatedPair PairOf(const LensModel& lens, double focal_px) {
  SimulatedPair pair;
  pair.file = "rig.yaml";
  pair.left = {focal_px, focal_px, 322, 197, lens};
  pair.right = {1.02 * focal_px, 1.01 * focal_px, 315, 205, lens};
  pair.right_from_left.rotation = Eigen::AngleAxisd(0.045, Eigen::Vector3d(2, 1, 3).normalized());
  pair.right_from_left.translation = pair.right_from_left.rotation * Eigen::Vector3d(-0.4, 0, 0);
  pair.width_px = kWidth;
  pair.height_px = kHeight;
  pair.told.raw = RawStereo{pair.left, pair.right, pair.right_from_left, kWidth, kHeight, 110};
  return pair;
}

SimulationSpec SpecOf(const SimulatedPair& pair) {
  SimulationSpec spec;
  spec.seed = 3;
  spec.length_m = 120;
  spec.pair = pair;
  return spec;
}

std::unique_ptr<SimulatedSequence> Open(const SimulationSpec& spec) {
  absl::StatusOr<std::unique_ptr<SimulatedSequence>> sequence = SimulatedSequence::Make(spec);
  EXPECT_TRUE(sequence.ok()) << sequence.status();
  return *std::move(sequence);
}

struct RowErrors {
  size_t matches = 0;
  double median_px = 0;  // Of how far apart the rows are.
  double lower_px = 0;   // By how much the right ones lie lower, the mean of those near the median.
};

double MedianOf(std::vector<double> values) {
  if (values.empty()) return 1e9;
  std::nth_element(values.begin(), values.begin() + static_cast<ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

// Matches ORB features of both pictures, those that are each other's best and not far apart.
RowErrors MeasureRows(const cv::Mat& left, const cv::Mat& right) {
  const auto orb = cv::ORB::create(1500, 1.2F, 1);
  std::vector<cv::KeyPoint> keypoints[2];
  cv::Mat descriptors[2];
  orb->detectAndCompute(left, cv::noArray(), keypoints[0], descriptors[0]);
  orb->detectAndCompute(right, cv::noArray(), keypoints[1], descriptors[1]);
  std::vector<cv::DMatch> matches;
  cv::BFMatcher(cv::NORM_HAMMING, true).match(descriptors[0], descriptors[1], matches);
  std::vector<double> apart;
  std::vector<double> lower;
  for (const cv::DMatch& match : matches) {
    const cv::Point2f a = keypoints[0][static_cast<size_t>(match.queryIdx)].pt;
    const cv::Point2f b = keypoints[1][static_cast<size_t>(match.trainIdx)].pt;
    if (match.distance > 30 || a.x < b.x || a.x > b.x + 60 || std::abs(a.y - b.y) > 20) continue;
    lower.push_back(b.y - a.y);
    apart.push_back(std::abs(lower.back()));
  }
  const double middle = MedianOf(lower);
  double sum = 0;
  double count = 0;
  for (const double each : lower) {
    if (std::abs(each - middle) > 2) continue;
    sum += each;
    ++count;
  }
  return {apart.size(), MedianOf(apart), count > 0 ? sum / count : 1e9};
}

// The rows of a pair that was drawn askew agree again once our own code has rectified it, and would
// not without.
TEST(LensSequenceTest, RectifiedPairsHaveEqualRows) {
  const std::pair<LensModel, double> lenses[] = {
      {RadialTangential{-0.28, 0.07, 0.0002, 0.00002, 0}, 420},
      {Equidistant{0.003, -0.002, 0.001, 0}, 230},  // 160 degrees from left to right.
      {DoubleSphere{-0.18, 0.59}, 190},
      {UnifiedSphere{1.1, {}}, 420}};
  for (const auto& [lens, focal_px] : lenses) {
    const SimulatedPair pair = PairOf(lens, focal_px);
    const auto sequence = Open(SpecOf(pair));
    const auto rectifier = StereoRectifier::Make(*pair.told.raw);
    ASSERT_TRUE(rectifier.ok()) << NameOf(lens) << rectifier.status();
    const auto images = sequence->Render(30);
    ASSERT_TRUE(images.ok()) << images.status();
    ASSERT_EQ(images->grey.size(), cv::Size(kWidth, kHeight));
    EXPECT_GT(MeasureRows(images->grey, images->right).median_px, 2) << NameOf(lens);
    cv::Mat left;
    cv::Mat right;
    ASSERT_TRUE(rectifier->RectifyLeft(images->grey, left).ok());
    ASSERT_TRUE(rectifier->RectifyRight(images->right, right).ok());
    const RowErrors errors = MeasureRows(left, right);
    EXPECT_GT(errors.matches, 100u) << NameOf(lens);
    EXPECT_LT(std::abs(errors.lower_px), 0.3) << NameOf(lens);
    EXPECT_LT(errors.median_px, 0.8) << NameOf(lens);
  }
}

TEST(LensSequenceTest, ErrorsOfTheCalibrationAreOfAnyPair) {
  const SimulatedPair pair = PairOf(RadialTangential{-0.1, 0.02}, 420);
  const auto rectifier = StereoRectifier::Make(*pair.told.raw);
  ASSERT_TRUE(rectifier.ok());
  SimulationSpec spec = SpecOf(pair);
  spec.epipolar_error_px = 4;
  const auto images = Open(spec)->Render(30);
  ASSERT_TRUE(images.ok());
  cv::Mat left;
  cv::Mat right;
  ASSERT_TRUE(rectifier->RectifyLeft(images->grey, left).ok());
  ASSERT_TRUE(rectifier->RectifyRight(images->right, right).ok());
  EXPECT_NEAR(MeasureRows(left, right).lower_px, 4, 0.7);
}

double MeanOf(const cv::Mat& picture) { return cv::mean(picture)[0]; }
double ContrastOf(const cv::Mat& picture) {
  cv::Mat fine;
  cv::Laplacian(picture, fine, CV_32F);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(fine, mean, deviation);
  return deviation[0];
}

TEST(LensSequenceTest, ABeginningIsDarkThenBlurredThenStill) {
  SimulationSpec spec = SpecOf(PairOf(Equidistant(), 230));
  spec.rate_hz = 10;
  const auto undisturbed = Open(spec);
  spec.beginning = {1, 1, 1};
  const auto sequence = Open(spec);
  EXPECT_EQ(sequence->frame_count(), undisturbed->frame_count() + 30);
  EXPECT_EQ(cv::countNonZero(sequence->Render(9)->grey), 0);
  const double sharp = ContrastOf(sequence->Render(20)->right);
  EXPECT_LT(ContrastOf(sequence->Render(10)->right), 0.5 * sharp);
  EXPECT_LT(
      (sequence->world_from_camera(29).translation - undisturbed->world_from_camera(0).translation)
          .norm(),
      1e-9);
  EXPECT_GT(
      (sequence->world_from_camera(60).translation - undisturbed->world_from_camera(0).translation)
          .norm(),
      1);
  EXPECT_LT(
      (sequence->world_from_camera(60).translation - undisturbed->world_from_camera(30).translation)
          .norm(),
      1e-6);
}

TEST(LensSequenceTest, AHandHidesBothPictures) {
  SimulationSpec spec = SpecOf(PairOf(Equidistant(), 230));
  spec.rate_hz = 10;
  spec.hand = {1, 1};
  const auto sequence = Open(spec);
  const auto hidden = *sequence->Render(15);
  EXPECT_LT(MeanOf(hidden.grey), 0.4 * MeanOf(sequence->Render(9)->grey));
  EXPECT_LT(MeanOf(hidden.right), 0.4 * MeanOf(sequence->Render(25)->right));
}

TEST(LensSequenceTest, RefusesWhatARigFileSaysAlready) {
  SimulationSpec spec = SpecOf(PairOf(Equidistant(), 230));
  spec.picture_scale = 0.5;
  EXPECT_NE(SimulatedSequence::Make(spec).status().message().find("picture_scale=0.5"),
            absl::string_view::npos);
}

}  // namespace
}  // namespace corbslam
