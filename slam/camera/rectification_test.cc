#include "slam/camera/rectification.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "slam/camera/pair_geometry.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;

// Returns a pair like EuRoC's: both lenses distort, and the right camera is turned by half a
// degree.
RawStereo RawPair() {
  RawStereo raw;
  raw.left = {458.654, 457.296, 367.215, 248.375,
              RadialTangential{-0.283, 0.0740, 0.000194, 0.0000176, 0}};
  raw.right = {457.587, 456.134, 379.999, 255.238,
               RadialTangential{-0.284, 0.0745, -0.000105, -0.0000356, 0}};
  raw.right_from_left.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.009, Eigen::Vector3d(1, 2, -0.5).normalized()));
  raw.right_from_left.translation = {-0.11, 0.0004, -0.0008};
  raw.width_px = 752;
  raw.height_px = 480;
  return raw;
}

Eigen::Vector2d RawPixel(const RawCamera& camera, const Eigen::Vector3d& x_in_camera) {
  return ProjectRaw(camera, x_in_camera).value_or(Eigen::Vector2d(-1, -1));
}

// Draws a raw picture with one soft white blob at a pixel.
cv::Mat BlobAt(const RawStereo& raw, const Eigen::Vector2d& pixel) {
  cv::Mat picture(raw.height_px, raw.width_px, CV_8UC1);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const double distance2 = (Eigen::Vector2d(x, y) - pixel).squaredNorm();
      picture.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(250 * std::exp(-distance2 / 18));
    }
  }
  return picture;
}

Eigen::Vector2d CentroidOf(const cv::Mat& picture) {
  const cv::Moments moments = cv::moments(picture);
  return {moments.m10 / moments.m00, moments.m01 / moments.m00};
}

TEST(RectificationTest, KeepsTheBaseline) {
  const auto rectifier = StereoRectifier::Make(RawPair());
  ASSERT_TRUE(rectifier.ok()) << rectifier.status();
  EXPECT_NEAR(rectifier->camera().baseline_m, RawPair().right_from_left.translation.norm(), 1e-9);
  EXPECT_EQ(rectifier->camera().width_px, 752);
  EXPECT_NEAR(rectifier->camera().close_depth_m, 40 * rectifier->camera().baseline_m, 1e-9);
}

TEST(RectificationTest, APointFallsWhereTheRectifiedCameraProjectsIt) {
  const RawStereo raw = RawPair();
  const auto rectifier = StereoRectifier::Make(raw);
  ASSERT_TRUE(rectifier.ok()) << rectifier.status();
  for (const Eigen::Vector3d& point : {Eigen::Vector3d(0.4, -0.3, 3), Eigen::Vector3d(-1, 0.5, 4),
                                       Eigen::Vector3d(0.1, 0.1, 1.5)}) {
    cv::Mat left, right;
    ASSERT_TRUE(rectifier->RectifyLeft(BlobAt(raw, RawPixel(raw.left, point)), left).ok());
    const Eigen::Vector3d in_right = raw.right_from_left * point;
    ASSERT_TRUE(rectifier->RectifyRight(BlobAt(raw, RawPixel(raw.right, in_right)), right).ok());

    const Eigen::Vector3d in_rectified = rectifier->rectified_from_raw_left() * point;
    const Eigen::Vector2d expected = Project(rectifier->camera(), in_rectified);
    const double disparity = DisparityFromDepth(rectifier->camera(), in_rectified.z());
    EXPECT_NEAR((CentroidOf(left) - expected).norm(), 0, 0.1);
    EXPECT_NEAR((CentroidOf(right) - expected + Eigen::Vector2d(disparity, 0)).norm(), 0, 0.1);
  }
}

// Pairs of three kinds of fisheyes, turned against each other as the pinholes are.
std::vector<RawStereo> FisheyePairs() {
  std::vector<RawStereo> pairs;
  for (const LensModel& lens :
       {LensModel(Equidistant{0.0035, 0.0007, -0.002, 0.0002}), LensModel(DoubleSphere{-0.2, 0.59}),
        LensModel(UnifiedSphere{1.2, {-0.1, 0.02, 0.0004, -0.0003, 0}})}) {
    RawStereo raw = RawPair();
    const double focal_px = lens.index() == 3 ? 500 : 230;
    raw.left = {focal_px, focal_px + 1, 374, 238, lens};
    raw.right = {focal_px - 1, focal_px, 379, 243, lens};
    pairs.push_back(raw);
  }
  return pairs;
}

TEST(RectificationTest, APointFallsWhereItShouldThroughFisheyes) {
  for (const RawStereo& raw : FisheyePairs()) {
    const auto rectifier = StereoRectifier::Make(raw);
    ASSERT_TRUE(rectifier.ok()) << rectifier.status();
    EXPECT_NEAR(rectifier->camera().baseline_m, raw.right_from_left.translation.norm(), 1e-9);
    for (const Eigen::Vector3d& point : {Eigen::Vector3d(0.4, -0.3, 3), Eigen::Vector3d(-2, 1, 3),
                                         Eigen::Vector3d(2.5, 0.5, 2.5)}) {
      const Eigen::Vector3d in_rectified = rectifier->rectified_from_raw_left() * point;
      const Eigen::Vector2d expected = Project(rectifier->camera(), in_rectified);
      if (!IsInImage(rectifier->camera(), expected)) continue;
      cv::Mat left, right;
      ASSERT_TRUE(rectifier->RectifyLeft(BlobAt(raw, RawPixel(raw.left, point)), left).ok());
      const Eigen::Vector3d in_right = raw.right_from_left * point;
      ASSERT_TRUE(rectifier->RectifyRight(BlobAt(raw, RawPixel(raw.right, in_right)), right).ok());
      const double disparity = DisparityFromDepth(rectifier->camera(), in_rectified.z());
      // A blob is stretched as it is rectified: its middle moves towards the edge.
      EXPECT_LT((CentroidOf(left) - expected).norm(), 1) << NameOf(raw.left.lens);
      const Eigen::Vector2d moved = CentroidOf(left) - CentroidOf(right);
      EXPECT_NEAR(moved.x(), disparity, 0.2) << NameOf(raw.left.lens);
      EXPECT_NEAR(moved.y(), 0, 0.2) << NameOf(raw.left.lens);
    }
  }
}

// The fisheyes' way, given a pair of pinholes, turns the pictures as OpenCV does.
TEST(RectificationTest, RotationsAgreeWithOpenCv) {
  const RawStereo raw = RawPair();
  const auto rectifier = StereoRectifier::Make(raw);
  ASSERT_TRUE(rectifier.ok());
  const Eigen::Quaterniond ours = RotationsOf(raw.right_from_left).rectified_from_left;
  EXPECT_LT(ours.angularDistance(rectifier->rectified_from_raw_left().rotation), 1e-6);
}

TEST(RectificationTest, ShowsNoPixelFromOutsideAndNoWiderFieldThanAsked) {
  for (RawStereo raw : FisheyePairs()) {
    for (const double widest_deg : {60.0, 110.0, 150.0}) {
      raw.widest_field_deg = widest_deg;
      const auto rectifier = StereoRectifier::Make(raw);
      ASSERT_TRUE(rectifier.ok()) << rectifier.status();
      const double half_rad = std::atan(0.5 * raw.width_px / rectifier->camera().fx_px);
      EXPECT_LE(half_rad * 360 / std::numbers::pi, widest_deg + 1e-6);
      const cv::Mat white(raw.height_px, raw.width_px, CV_8UC1, cv::Scalar(255));
      cv::Mat left, right;
      ASSERT_TRUE(rectifier->RectifyLeft(white, left).ok());
      ASSERT_TRUE(rectifier->RectifyRight(white, right).ok());
      EXPECT_EQ(cv::countNonZero(left < 255) + cv::countNonZero(right < 255), 0)
          << NameOf(raw.left.lens) << " at " << widest_deg;
    }
  }
}

TEST(RectificationTest, RefusesFisheyesThatSeeNothingInCommon) {
  RawStereo raw = FisheyePairs().front();
  raw.left.cx_px = 3000;
  EXPECT_THAT(StereoRectifier::Make(raw).status().message(), HasSubstr("in common"));
  raw = FisheyePairs().front();
  raw.widest_field_deg = 170;
  EXPECT_THAT(StereoRectifier::Make(raw).status().message(), HasSubstr("widest_field_deg is 170"));
}

TEST(RectificationTest, RefusesARightCameraOnTheLeft) {
  RawStereo raw = RawPair();
  raw.right_from_left = raw.right_from_left.Inverse();
  EXPECT_THAT(StereoRectifier::Make(raw).status().message(), HasSubstr("+x"));
}

TEST(RectificationTest, RefusesAnImageOfAnotherSize) {
  const auto rectifier = StereoRectifier::Make(RawPair());
  ASSERT_TRUE(rectifier.ok());
  cv::Mat rectified;
  const absl::Status status = rectifier->RectifyLeft(cv::Mat::zeros(480, 640, CV_8UC1), rectified);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("752x480"));
  EXPECT_THAT(status.message(), HasSubstr("640x480"));
}

}  // namespace
}  // namespace corbslam
