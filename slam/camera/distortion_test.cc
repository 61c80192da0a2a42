#include "slam/camera/distortion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <opencv2/calib3d.hpp>
#include <vector>

namespace corbslam {
namespace {

using ::testing::HasSubstr;

// These are the coefficients of the RGB-D sensor of TUM's freiburg1 and of EuRoC's left camera.
const RadialTangential kStrong = {
    .k1 = 0.262383, .k2 = -0.953104, .p1 = -0.005358, .p2 = 0.002628, .k3 = 1.163314};
const RadialTangential kBarrel = {
    .k1 = -0.28340811, .k2 = 0.07395907, .p1 = 0.00019359, .p2 = 1.76187114e-05, .k3 = 0};

TEST(DistortionTest, UndistortInvertsDistortOverTheWholeView) {
  for (const RadialTangential& distortion : {kStrong, kBarrel}) {
    for (double y = -0.45; y <= 0.45; y += 0.05) {
      for (double x = -0.6; x <= 0.6; x += 0.05) {
        const Eigen::Vector2d ideal(x, y);
        const Eigen::Vector2d back = Undistort(distortion, Distort(distortion, ideal));
        EXPECT_NEAR((back - ideal).norm(), 0, 1e-9) << x << ", " << y;
      }
    }
  }
}

TEST(DistortionTest, AgreesWithOpenCv) {
  const std::vector<cv::Point3d> points = {{0.3, -0.2, 1}, {-0.5, 0.4, 1}, {0.1, 0.35, 1}};
  std::vector<cv::Point2d> projected;
  cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), cv::Matx33d::eye(),
                    cv::Vec<double, 5>(kStrong.k1, kStrong.k2, kStrong.p1, kStrong.p2, kStrong.k3),
                    projected);
  for (size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d ours = Distort(kStrong, {points[i].x, points[i].y});
    EXPECT_NEAR(ours.x(), projected[i].x, 1e-12);
    EXPECT_NEAR(ours.y(), projected[i].y, 1e-12);
  }
}

TEST(DistortionTest, TheRationalModelAgreesWithOpenCvAndIsInverted) {
  // The colour camera of an Azure Kinect.
  const RadialTangential rational = {.k1 = 0.5,
                                     .k2 = -2.6,
                                     .p1 = 0.0006,
                                     .p2 = -0.0002,
                                     .k3 = 1.5,
                                     .k4 = 0.38,
                                     .k5 = -2.43,
                                     .k6 = 1.44};
  const cv::Vec<double, 8> coefficients(rational.k1, rational.k2, rational.p1, rational.p2,
                                        rational.k3, rational.k4, rational.k5, rational.k6);
  for (const Eigen::Vector2d& ideal :
       {Eigen::Vector2d(0.3, -0.2), Eigen::Vector2d(-0.5, 0.4), Eigen::Vector2d(0.1, 0.35)}) {
    std::vector<cv::Point2d> projected;
    cv::projectPoints(std::vector<cv::Point3d>{{ideal.x(), ideal.y(), 1}}, cv::Vec3d(), cv::Vec3d(),
                      cv::Matx33d::eye(), coefficients, projected);
    const Eigen::Vector2d ours = Distort(rational, ideal);
    EXPECT_NEAR(ours.x(), projected[0].x, 1e-12);
    EXPECT_NEAR(ours.y(), projected[0].y, 1e-12);
    EXPECT_NEAR((Undistort(rational, ours) - ideal).norm(), 0, 1e-9);
  }
}

TEST(DistortionTest, StaysFiniteWhereTheModelFoldsOver) {
  const RadialTangential folding = {.k1 = -0.9};
  EXPECT_TRUE(Undistort(folding, {3, 3}).allFinite());
}

TEST(DistortionTest, RejectsACoefficientThatIsNotFinite) {
  RadialTangential distortion;
  distortion.p2 = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Validate(distortion).message(), HasSubstr("p2 is nan"));
  EXPECT_TRUE(Validate(kStrong).ok());
}

}  // namespace
}  // namespace corbslam
