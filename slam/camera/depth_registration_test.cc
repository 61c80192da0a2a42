#include "slam/camera/depth_registration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace corbslam {
namespace {

using ::testing::HasSubstr;

// A wall, slanted by `slope` metres a metre, and before it a board that covers a part of the view:
// in the depth camera's frame.
struct Scene {
  double wall_m = 3;
  double slope = 0.2;
  double board_m = 1.2;
  Eigen::Vector2d board_low_m = {-0.25, -0.2};
  Eigen::Vector2d board_high_m = {0.2, 0.25};

  // Returns how far along `ray` from `eye` something is hit.
  double Hit(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) const {
    const double to_board = (board_m - eye.z()) / ray.z();
    const Eigen::Vector2d at = (eye + to_board * ray).head<2>();
    if (to_board > 0 && (at.array() > board_low_m.array()).all() &&
        (at.array() < board_high_m.array()).all()) {
      return to_board;
    }
    // z = wall + slope x.
    return (wall_m + slope * eye.x() - eye.z()) / (ray.z() - slope * ray.x());
  }
  // Returns the depth along the axis of a camera with that pose, 0 where nothing is seen.
  double DepthAt(const RawCamera& camera, const Rigid3d& camera_from_depth, double x,
                 double y) const {
    const auto direction = UnprojectRaw(camera, {x, y});
    if (!direction.has_value()) return 0;
    const Rigid3d depth_from_camera = camera_from_depth.Inverse();
    const Eigen::Vector3d ray = depth_from_camera.rotation * *direction;
    const double distance = Hit(depth_from_camera.translation, ray);
    return distance > 0 ? distance * direction->z() : 0;
  }
  cv::Mat Take(const RawCamera& camera, const Rigid3d& camera_from_depth,
               const cv::Size& size) const {
    cv::Mat depth(size, CV_32FC1);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        depth.at<float>(y, x) = static_cast<float>(DepthAt(camera, camera_from_depth, x, y));
      }
    }
    return depth;
  }
};

DepthGeometry Kinect() {
  DepthGeometry geometry;
  geometry.depth = {290, 291, 158.5, 121.5, {}};
  geometry.depth_px = {320, 240};
  geometry.colour = {260, 259, 161, 118, {}};
  geometry.colour_px = {320, 240};
  geometry.colour_from_depth.translation = {-0.025, 0.002, 0.004};
  geometry.colour_from_depth.rotation =
      Eigen::AngleAxisd(0.012, Eigen::Vector3d(0.3, 1, 0.5).normalized());
  return geometry;
}

cv::Mat Register(const DepthGeometry& geometry, const cv::Mat& depth, double units_per_m = 1000) {
  const auto registration = DepthRegistration::Make(geometry);
  EXPECT_TRUE(registration.ok()) << registration.status();
  auto registered = registration->Register(depth, units_per_m);
  EXPECT_TRUE(registered.ok()) << registered.status();
  return *std::move(registered);
}

struct Compared {
  double wrong_share = 0;    // Of the pixels with depth away from outlines.
  double missing_share = 0;  // Of the pixels that both cameras see, away from outlines.
  size_t through = 0;        // Pixels of the board, away from its outline, that show the wall.
  size_t guessed = 0;        // Pixels with depth of what the depth camera doesn't see.
};

// Compares with what the colour camera would measure itself.
Compared CompareWithTruth(const Scene& scene, const DepthGeometry& geometry,
                          const cv::Mat& registered_m) {
  const Rigid3d& colour_from_depth = geometry.colour_from_depth;
  const cv::Mat truth = scene.Take(geometry.colour, colour_from_depth, geometry.colour_px);
  // Outlines are where neighbours within two pixels differ much.
  cv::Mat low;
  cv::Mat high;
  cv::erode(truth, low, cv::Mat::ones(5, 5, CV_8U));
  cv::dilate(truth, high, cv::Mat::ones(5, 5, CV_8U));
  Compared compared;
  double both = 0, missing = 0, given = 0, wrong = 0;
  for (int y = 4; y < truth.rows - 4; ++y) {
    for (int x = 4; x < truth.cols - 4; ++x) {
      const double z = truth.at<float>(y, x);
      if (high.at<float>(y, x) > 1.2F * low.at<float>(y, x) || z <= 0) continue;
      const Eigen::Vector3d point =
          colour_from_depth.Inverse() *
          Eigen::Vector3d(*UnprojectRaw(geometry.colour, {x, y}) *
                          (z / UnprojectRaw(geometry.colour, {x, y})->z()));
      const auto seen = ProjectRaw(geometry.depth, point);
      const bool is_inside = seen.has_value() && seen->x() > 2 && seen->y() > 2 &&
                             seen->x() < geometry.depth_px.width - 3 &&
                             seen->y() < geometry.depth_px.height - 3;
      // The board stands between the depth camera and the point, by two pixels all around.
      bool is_hidden = false;
      bool is_clearly_hidden = is_inside;
      for (const double dx : {-2, 0, 2}) {
        for (const double dy : {-2, 0, 2}) {
          const bool hidden = is_inside && scene.DepthAt(geometry.depth, {}, seen->x() + dx,
                                                         seen->y() + dy) < 0.8 * point.z();
          is_hidden |= hidden;
          is_clearly_hidden &= hidden;
        }
      }
      const double found = registered_m.at<float>(y, x);
      if (found > 0 && is_clearly_hidden) ++compared.guessed;
      if (found > 1.2 * z) ++compared.through;
      if (!is_inside || is_hidden) continue;
      ++both;
      if (found == 0) ++missing;
      if (found > 0) ++given;
      // A pixel of a slanted plane covers a range of depths.
      const bool fits = found > 0.99 * low.at<float>(y, x) && found < 1.01 * high.at<float>(y, x);
      if (found > 0 && !fits) ++wrong;
    }
  }
  EXPECT_GT(both, 0.15 * truth.rows * truth.cols);
  compared.missing_share = missing / both;
  compared.wrong_share = wrong / given;
  return compared;
}

void ExpectRight(const DepthGeometry& geometry) {
  const Scene scene;
  const cv::Mat depth = scene.Take(geometry.depth, {}, geometry.depth_px);
  const Compared compared = CompareWithTruth(scene, geometry, Register(geometry, depth));
  EXPECT_EQ(compared.missing_share, 0);
  EXPECT_EQ(compared.wrong_share, 0);
  EXPECT_EQ(compared.through, 0u);
  EXPECT_EQ(compared.guessed, 0u);
}

TEST(DepthRegistrationTest, GivesWhatTheColourCameraWouldMeasure) { ExpectRight(Kinect()); }

TEST(DepthRegistrationTest, ThroughLensesThatDistort) {
  DepthGeometry geometry = Kinect();
  geometry.depth.lens = RadialTangential{.k1 = -0.12, .k2 = 0.05, .p1 = 0.001, .p2 = -0.002};
  geometry.colour.lens = RadialTangential{.k1 = 0.08, .k2 = -0.1, .p1 = -0.001};
  ExpectRight(geometry);
}

TEST(DepthRegistrationTest, ThroughFisheyes) {
  DepthGeometry geometry = Kinect();
  geometry.colour = {75, 75, 80, 60, Equidistant{.k1 = 0.02, .k2 = -0.003}};
  geometry.colour_px = {160, 120};
  ExpectRight(geometry);
  geometry.depth = {80, 80, 80, 60, Equidistant{.k1 = -0.01}};
  geometry.depth_px = {160, 120};
  ExpectRight(geometry);
}

// A depth pixel covers more than two of the colour picture's a side: no holes between them.
TEST(DepthRegistrationTest, CoversWhatADepthPixelCovers) {
  DepthGeometry geometry = Kinect();
  geometry.colour = {624, 622, 386, 283, {}};
  geometry.colour_px = {768, 576};
  ExpectRight(geometry);
}

TEST(DepthRegistrationTest, FarFewerColourPixelsThanDepth) {
  DepthGeometry geometry = Kinect();
  geometry.colour = {65, 65, 40, 30, {}};
  geometry.colour_px = {80, 60};
  ExpectRight(geometry);
}

TEST(DepthRegistrationTest, SixteenBitsKeepTheirUnits) {
  const DepthGeometry geometry = Kinect();
  const cv::Mat metres = Scene().Take(geometry.depth, {}, geometry.depth_px);
  cv::Mat depth;
  metres.convertTo(depth, CV_16U, 5000);
  const cv::Mat whole = Register(geometry, depth, 5000);
  const cv::Mat real = Register(geometry, metres);
  ASSERT_EQ(whole.type(), CV_16UC1);
  cv::Mat as_metres;
  whole.convertTo(as_metres, CV_32F, 1 / 5000.0);
  cv::Mat apart;
  cv::absdiff(as_metres, real, apart);
  // Which of two neighbours is nearer may be decided by rounding, on a slope of a few millimetres.
  double most = 0;
  cv::minMaxLoc(apart, nullptr, &most);
  EXPECT_LT(most, 0.006);
  EXPECT_LT(cv::mean(apart)[0], 0.0003);
}

TEST(DepthRegistrationTest, NoDepthStaysNone) {
  DepthGeometry same;
  same.depth = same.colour = {100, 100, 10, 10, {}};
  same.depth_px = same.colour_px = {20, 20};
  cv::Mat depth(20, 20, CV_16UC1, cv::Scalar(1500));
  depth.at<uint16_t>(2, 3) = 0;
  depth.at<uint16_t>(5, 6) = 65535;
  cv::Mat expected = depth.clone();
  expected.at<uint16_t>(5, 6) = 0;
  EXPECT_EQ(cv::norm(Register(same, depth), expected, cv::NORM_INF), 0);
  cv::Mat metres(20, 20, CV_32FC1, cv::Scalar(1.5F));
  metres.at<float>(1, 1) = std::numeric_limits<float>::quiet_NaN();
  metres.at<float>(1, 3) = std::numeric_limits<float>::infinity();
  metres.at<float>(1, 5) = -1;
  const cv::Mat registered = Register(same, metres);
  EXPECT_EQ(cv::countNonZero(registered), 400 - 3);
  EXPECT_EQ(registered.at<float>(1, 1), 0);
}

TEST(DepthRegistrationTest, RefusesWhatCantBe) {
  DepthGeometry geometry = Kinect();
  geometry.colour_from_depth.translation.x() = 25;
  EXPECT_THAT(std::string(DepthRegistration::Make(geometry).status().message()),
              HasSubstr("25 m apart, must be at most 1"));
  geometry = Kinect();
  geometry.depth.fx_px = -1;
  EXPECT_THAT(std::string(DepthRegistration::Make(geometry).status().message()),
              HasSubstr("depth camera"));
  const auto registration = DepthRegistration::Make(Kinect());
  EXPECT_THAT(
      std::string(registration->Register(cv::Mat(240, 320, CV_8UC1), 1000).status().message()),
      HasSubstr("a depth picture of 320x240 CV_8UC1, its camera's are of 320x240"));
  EXPECT_FALSE(registration->Register(cv::Mat(120, 320, CV_16UC1), 1000).ok());
}

}  // namespace
}  // namespace corbslam
