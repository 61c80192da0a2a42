#include "slam/camera/lens.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <string>
#include <vector>

namespace corbslam {
namespace {

using ::testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;

// Lenses of real cameras, and how far from the axis each model is asked.
struct KnownLens {
  const char* name;
  LensModel model;
  double widest_deg;
};
const std::vector<KnownLens> kLenses = {
    {"EuRoC", RadialTangential{-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0}, 40},
    {"AzureKinect", RadialTangential{0.5, -2.6, 0.0006, -0.0002, 1.5, 0.38, -2.43, 1.44}, 40},
    {"TumVi", Equidistant{0.0034823894, 0.0007150348, -0.0020532361, 0.00020293673}, 97},
    {"Equidistant", Equidistant{}, 120},
    {"DoubleSphere", DoubleSphere{-0.2, 0.59}, 97},
    {"DoubleSphereWeak", DoubleSphere{0.1, 0.3}, 80},
    {"Omni", UnifiedSphere{1.47, {-0.22, 0.1, 0.0004, -0.0003, 0}}, 95},
    {"OmniHalf", UnifiedSphere{0.8, {}}, 100}};

Eigen::Vector3d Towards(double from_axis_deg, double around_deg) {
  const double across = std::sin(from_axis_deg * kDegree);
  return {across * std::cos(around_deg * kDegree), across * std::sin(around_deg * kDegree),
          std::cos(from_axis_deg * kDegree)};
}

TEST(LensTest, EachDirectionComesBack) {
  for (const auto& [name, model, widest_deg] : kLenses) {
    for (double angle = 0; angle <= widest_deg; angle += 2.5) {
      for (double around = 0; around < 360; around += 30) {
        const Eigen::Vector3d direction = Towards(angle, around);
        const auto seen = SeenAt(model, 3.5 * direction);
        ASSERT_TRUE(seen.has_value()) << name << " at " << angle << " degrees";
        const auto back = DirectionOf(model, *seen);
        ASSERT_TRUE(back.has_value()) << name << " at " << angle << " degrees";
        EXPECT_NEAR(back->norm(), 1, 1e-12);
        EXPECT_LT((*back - direction).norm(), 1e-7) << name << " at " << angle << " degrees";
      }
    }
  }
}

// The farther from the axis, the farther from the middle, without jumps: the map has a slope that
// numbers can find, which no branch of the code breaks.
TEST(LensTest, GrowsSmoothlyFromTheMiddle) {
  constexpr double kStep_deg = 0.5;
  for (const auto& [name, model, widest_deg] : kLenses) {
    double before = 0;
    double slope_before = 0;
    for (double angle = kStep_deg; angle <= widest_deg; angle += kStep_deg) {
      const double radius = SeenAt(model, Towards(angle, 20))->norm();
      const double slope = (radius - before) / (kStep_deg * kDegree);
      EXPECT_GT(slope, 0) << name << " at " << angle << " degrees";
      if (slope_before > 0) {
        EXPECT_LT(std::abs(slope / slope_before - 1), 0.1) << name << " at " << angle;
      }
      before = radius;
      slope_before = slope;
    }
  }
}

TEST(LensTest, TheEquidistantOneAgreesWithOpenCv) {
  const cv::Vec4d k(0.0034823894, 0.0007150348, -0.0020532361, 0.00020293673);
  const cv::Matx33d camera(190.97, 0, 254.93, 0, 190.97, 256.89, 0, 0, 1);
  const RawCamera ours = {190.97, 190.97, 254.93, 256.89, Equidistant{k[0], k[1], k[2], k[3]}};
  const std::vector<cv::Point3d> points = {{0.3, -0.2, 1}, {-2, 1, 0.5}, {0.01, 3, 0.4}, {0, 0, 1}};
  std::vector<cv::Point2d> projected;
  cv::fisheye::projectPoints(points, projected, cv::Vec3d(), cv::Vec3d(), camera, k);
  for (size_t i = 0; i < points.size(); ++i) {
    const auto pixel = ProjectRaw(ours, {points[i].x, points[i].y, points[i].z});
    ASSERT_TRUE(pixel.has_value());
    EXPECT_NEAR(pixel->x(), projected[i].x, 1e-9);
    EXPECT_NEAR(pixel->y(), projected[i].y, 1e-9);
  }
}

// A unified sphere of xi 0 is a pinhole; a double sphere of alpha 0 and xi 0, too.
TEST(LensTest, SpheresBecomePinholes) {
  const RadialTangential bent = {-0.2, 0.05, 0.001, -0.002, 0};
  const Eigen::Vector3d direction(0.3, -0.2, 1);
  EXPECT_LT((*SeenAt(UnifiedSphere{0, bent}, direction) - *SeenAt(bent, direction)).norm(), 1e-12);
  EXPECT_LT((*SeenAt(DoubleSphere{0, 0}, direction) - direction.head<2>()).norm(), 1e-12);
}

TEST(LensTest, SaysWhatItDoesNotSee) {
  EXPECT_FALSE(SeenAt(RadialTangential{}, {0, 0, -1}).has_value());
  EXPECT_FALSE(SeenAt(RadialTangential{}, {1, 0, 0}).has_value());
  EXPECT_FALSE(SeenAt(RadialTangential{-0.9}, {3, 0, 1}).has_value()) << "beyond the fold";
  EXPECT_FALSE(SeenAt(Equidistant{}, {0, 0, -1}).has_value()) << "which way would it fall?";
  EXPECT_FALSE(SeenAt(Equidistant{-0.3}, Towards(100, 0)).has_value()) << "beyond the fold";
  EXPECT_FALSE(SeenAt(DoubleSphere{0.1, 0.3}, {0, 0, -1}).has_value());
  EXPECT_FALSE(SeenAt(UnifiedSphere{0.8, {}}, Towards(150, 0)).has_value());
  EXPECT_FALSE(DirectionOf(Equidistant{-0.3}, {5, 0}).has_value());
  EXPECT_FALSE(DirectionOf(Equidistant{}, {4, 0}).has_value()) << "more than half a turn";
  EXPECT_FALSE(DirectionOf(DoubleSphere{0.1, 0.9}, {4, 0}).has_value());
  EXPECT_FALSE(DirectionOf(UnifiedSphere{1.5, {}}, {4, 0}).has_value());
}

TEST(LensTest, RefusesImpossibleNumbers) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<LensModel, std::string>> cases = {
      {RadialTangential{.k6 = kNan}, "k6 is nan"},
      {Equidistant{.k3 = 200}, "k3 is 200"},
      {DoubleSphere{.xi = 1.5}, "xi is 1.5, must be in [-1, 1]"},
      {DoubleSphere{.alpha = -0.1}, "alpha is -0.1"},
      {UnifiedSphere{.xi = kNan, .distortion = {}}, "xi is nan"},
      {UnifiedSphere{.xi = 1, .distortion = {.k1 = 1e9}}, "k1 is 1e+09"}};
  for (const auto& [model, says] : cases) {
    EXPECT_THAT(std::string(Validate(model).message()), HasSubstr(says));
  }
  for (const KnownLens& lens : kLenses) EXPECT_TRUE(Validate(lens.model).ok()) << lens.name;
}

TEST(LensTest, UndistortsPixels) {
  const Camera camera = {.fx_px = 500, .fy_px = 510, .cx_px = 320, .cy_px = 240};
  EXPECT_EQ(UndistortPixel(camera, {}, {12.25, 400.5}), Eigen::Vector2d(12.25, 400.5));
  const Equidistant fisheye = {0.01, -0.002, 0, 0};
  const Eigen::Vector3d direction = Towards(50, 10);
  const Eigen::Vector2d raw = *ProjectRaw({500, 510, 320, 240, fisheye}, direction);
  const auto ideal = UndistortPixel(camera, fisheye, raw);
  ASSERT_TRUE(ideal.has_value());
  EXPECT_LT((*ideal - Project(camera, direction)).norm(), 1e-6);
  const Eigen::Vector2d behind = *ProjectRaw({500, 510, 320, 240, fisheye}, Towards(85, 10));
  EXPECT_FALSE(UndistortPixel(camera, fisheye, behind).has_value());
}

}  // namespace
}  // namespace corbslam
