#include "services/simulation/renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <utility>

namespace corbslam {
namespace {

Camera SmallCamera() {
  return {
      .fx_px = 100, .fy_px = 100, .cx_px = 59.5, .cy_px = 39.5, .width_px = 121, .height_px = 83};
}

// A wall of 40 m by 40 m that faces the camera.
Patch Wall(float depth_m, Material material, uint32_t seed = 7, float tone = 1) {
  return Rectangle({-20, -20, depth_m}, {40, 0, 0}, {0, 40, 0}, material, seed, tone);
}

Scene SceneOf(std::vector<Patch> patches) {
  Scene scene;
  scene.meshes.push_back({std::move(patches)});
  scene.instances.push_back({});
  return scene;
}

Lens NoiselessLens() {
  return {.exposure = 1, .vignetting = 0, .blur_px = 0, .read_noise = 0, .shot_noise = 0};
}

bool SameBytes(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(RendererTest, TheSameBytesWithOneThreadAndThree) {
  const Scene scene = SceneOf({Wall(9, Material::kFacade), Wall(5, Material::kGrass)});
  const Shot shot{.stream = 5};
  const cv::Mat one = Renderer(scene, Lens()).DrawGrey(SmallCamera(), shot);
  const cv::Mat three = Renderer(scene, Lens(), 3).DrawGrey(SmallCamera(), shot);
  EXPECT_TRUE(SameBytes(one, three));
}

// Bands that are exposed where the camera stands make the same picture; a camera that moves to the
// right meanwhile bends what is upright.
TEST(RendererTest, BandsAreExposedWhereTheCameraIs) {
  const Scene scene = SceneOf({Wall(9, Material::kFacade)});
  const Renderer renderer(scene, NoiselessLens(), 2);
  const cv::Mat whole = renderer.DrawGrey(SmallCamera(), {});
  Shot shot;
  shot.bands.resize(20);
  EXPECT_LE(cv::norm(whole, renderer.DrawGrey(SmallCamera(), shot), cv::NORM_L1),
            0.1 * static_cast<double>(whole.total()));
  shot.bands[19].world_from_camera.translation.x() = 0.9;  // Ten pixels of the wall.
  const cv::Mat bent = renderer.DrawGrey(SmallCamera(), shot);
  Shot moved;
  moved.world_from_camera = shot.bands[19].world_from_camera;
  const cv::Mat there = renderer.DrawGrey(SmallCamera(), moved);
  const int last = 19 * whole.rows / 20;
  Shot still;
  still.bands.resize(20);
  EXPECT_EQ(cv::norm(bent.rowRange(0, last),
                     renderer.DrawGrey(SmallCamera(), still).rowRange(0, last), cv::NORM_INF),
            0);
  EXPECT_LT(
      cv::norm(bent.rowRange(last, whole.rows), there.rowRange(last, whole.rows), cv::NORM_L1),
      0.1 * whole.cols * (whole.rows - last));
  EXPECT_GT(
      cv::norm(bent.rowRange(last, whole.rows), whole.rowRange(last, whole.rows), cv::NORM_L1),
      1.0 * whole.cols * (whole.rows - last));
  const cv::Mat depth = renderer.DrawDepth(SmallCamera(), shot);
  EXPECT_NEAR(depth.at<float>(2, 60), 9, 1e-3);
  EXPECT_NEAR(depth.at<float>(80, 60), 9, 1e-3);
}

TEST(RendererTest, NoiseDiffersBetweenStreamsAndRepeatsWithinOne) {
  const Renderer renderer(SceneOf({Wall(9, Material::kPlaster)}), Lens());
  const cv::Mat first = renderer.DrawGrey(SmallCamera(), {.stream = 1});
  EXPECT_TRUE(SameBytes(first, renderer.DrawGrey(SmallCamera(), {.stream = 1})));
  EXPECT_FALSE(SameBytes(first, renderer.DrawGrey(SmallCamera(), {.stream = 2})));
}

TEST(RendererTest, DepthIsTheDistanceAlongTheOpticalAxis) {
  const Renderer renderer(SceneOf({Wall(12, Material::kBrick)}), Lens());
  Shot shot;
  shot.world_from_camera.translation = {0.5, -0.25, 2};
  const cv::Mat depth = renderer.DrawDepth(SmallCamera(), shot);
  EXPECT_NEAR(depth.at<float>(0, 0), 10, 1e-4);
  EXPECT_NEAR(depth.at<float>(41, 60), 10, 1e-4);
}

TEST(RendererTest, DepthOfASlantedGroundFollowsTheRow) {
  // The ground lies 1.65 m below the camera: its depth is f h / (row - cy).
  const Scene scene =
      SceneOf({Rectangle({-100, 1.65F, 0.5F}, {200, 0, 0}, {0, 0, 300}, Material::kAsphalt, 1)});
  const cv::Mat depth = Renderer(scene, Lens()).DrawDepth(SmallCamera(), {});
  EXPECT_NEAR(depth.at<float>(80, 20), 100 * 1.65 / (80 - 39.5), 1e-3);
  EXPECT_EQ(depth.at<float>(10, 20), 0);  // There is only the sky.
}

TEST(RendererTest, TheNearerSurfaceHidesTheFarther) {
  const Patch half = Rectangle({0, -20, 4}, {20, 0, 0}, {0, 40, 0}, Material::kBrick, 3);
  const cv::Mat depth =
      Renderer(SceneOf({Wall(8, Material::kBrick), half}), Lens()).DrawDepth(SmallCamera(), {});
  EXPECT_NEAR(depth.at<float>(40, 20), 8, 1e-4);
  EXPECT_NEAR(depth.at<float>(40, 100), 4, 1e-4);
}

TEST(RendererTest, StereoViewsShowTheSameSurfaceOneDisparityApart) {
  const Renderer renderer(SceneOf({Wall(10, Material::kFacade)}), NoiselessLens());
  const cv::Mat left = renderer.DrawGrey(SmallCamera(), {});
  Shot shifted;
  // The picture shifts by 100 px * 0.5 m / 10 m = 5 px.
  shifted.world_from_camera.translation.x() = 0.5;
  const cv::Mat right = renderer.DrawGrey(SmallCamera(), shifted);
  const cv::Mat overlap_left = left.colRange(5, 121);
  const cv::Mat overlap_right = right.colRange(0, 116);
  EXPECT_LT(cv::norm(overlap_left, overlap_right, cv::NORM_INF), 2);
  EXPECT_GT(cv::norm(left, right, cv::NORM_INF), 20);
}

TEST(RendererTest, EdgesAreAveraged) {
  // A dark wall whose edge crosses the columns at a slope: levels between must appear.
  Patch dark = Wall(5, Material::kTyre);
  dark.corners = {Eigen::Vector3f(-20, -20, 5), {-1, -20, 5}, {1, 20, 5}, {-20, 20, 5}};
  const cv::Mat picture = Renderer(SceneOf({Wall(9, Material::kCeiling), dark}), NoiselessLens())
                              .DrawGrey(SmallCamera(), {});
  int between = 0;
  for (int y = 0; y < picture.rows; ++y) {
    bool found = false;
    for (int x = 45; x < 75; ++x) {
      const int level = picture.at<uint8_t>(y, x);
      found = found || (level > 60 && level < 110);
    }
    between += found ? 1 : 0;
  }
  EXPECT_GT(between, picture.rows / 4);
}

TEST(RendererTest, WhatIsFinerThanAPixelAveragesOut) {
  // Far away, a wall's grain must not flicker when the camera moves by a fraction of a pixel.
  const Renderer renderer(SceneOf({Wall(9, Material::kBrick)}), NoiselessLens());
  Camera coarse = SmallCamera();
  coarse.fx_px = coarse.fy_px = 6;  // A pixel is 1.5 m wide.
  const cv::Mat here = renderer.DrawGrey(coarse, {});
  Shot moved;
  moved.world_from_camera.translation.x() = 0.75;
  const cv::Mat there = renderer.DrawGrey(coarse, moved);
  const cv::Rect inside(54, 34, 12, 12);
  EXPECT_LT(cv::norm(here(inside), there(inside), cv::NORM_INF), 14);
}

TEST(RendererTest, MoversAreWhereTheTimeSays) {
  Scene scene = SceneOf({Wall(20, Material::kBrick)});
  scene.meshes.push_back({{Rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, Material::kCarPaint, 4)}});
  Mover mover{.mesh = 1};
  mover.path.push_back({0, {Eigen::Quaterniond::Identity(), {0, 0, 5}}});
  mover.path.push_back({2, {Eigen::Quaterniond::Identity(), {0, 0, 9}}});
  scene.movers.push_back(mover);
  const Renderer renderer(scene, Lens());
  const auto depth_at = [&](double time_s) {
    return renderer.DrawDepth(SmallCamera(), {.time_s = time_s}).at<float>(39, 60);
  };
  EXPECT_NEAR(depth_at(-1), 5, 1e-4);
  EXPECT_NEAR(depth_at(1), 7, 1e-4);
  EXPECT_NEAR(depth_at(3), 9, 1e-4);
}

TEST(RendererTest, InstancesCarryScaleAndRotation) {
  Scene scene;
  scene.meshes.push_back({{Rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, Material::kSign, 4)}});
  Instance instance;
  instance.world_from_mesh = {3, Eigen::Quaterniond::Identity(), {0, 0, 6}};
  scene.instances.push_back(instance);
  const cv::Mat depth = Renderer(scene, Lens()).DrawDepth(SmallCamera(), {});
  // Three metres to each side at 6 m: 50 px.
  EXPECT_NEAR(depth.at<float>(39, 11), 6, 1e-4);
  EXPECT_EQ(depth.at<float>(39, 7), 0);
}

TEST(RendererTest, NoiseHasTheDeviationThatTheLensSays) {
  Lens lens = NoiselessLens();
  lens.read_noise = 3;
  const Scene scene = SceneOf({Wall(6, Material::kPlaster)});
  cv::Mat difference;
  cv::subtract(Renderer(scene, lens).DrawGrey(SmallCamera(), {}),
               Renderer(scene, NoiselessLens()).DrawGrey(SmallCamera(), {}), difference,
               cv::noArray(), CV_32F);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(difference, mean, deviation);
  EXPECT_NEAR(mean[0], 0, 0.15);
  EXPECT_NEAR(deviation[0], 3, 0.15);
}

}  // namespace
}  // namespace corbslam
