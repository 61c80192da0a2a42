#include "services/simulation/lens_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "services/simulation/renderer.h"

namespace corbslam {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr int kWidth = 400;
constexpr int kHeight = 300;

struct Case {
  std::string name;
  RawCamera camera;
  double widest_rad;  // Markers are at most so far from the axis.
};

// The fisheyes see 190 degrees and more from corner to corner.
std::vector<Case> Cases() {
  return {
      {"radial_tangential", {250, 252, 201, 148, RadialTangential{-0.28, 0.07, 2e-4, 2e-5}}, 0.7},
      {"equidistant", {140, 141, 198, 151, Equidistant{0.003, -0.002, 0.001, 0}}, 1.66},
      {"double_sphere", {110, 110, 200, 150, DoubleSphere{-0.18, 0.59}}, 1.66},
      {"unified", {260, 260, 199, 149, UnifiedSphere{1.2, {}}}, 1.6}};
}

Lens NoiselessLens() {
  return {.exposure = 1, .vignetting = 0, .blur_px = 0, .read_noise = 0, .shot_noise = 0};
}

// A small square that faces the camera in this direction, alone in the dark.
Scene MarkerAt(const Vector3d& direction, double side_rad) {
  const Vector3d across = side_rad * direction.unitOrthogonal();
  const Vector3d down = direction.cross(across);
  const Vector3d corner = direction - 0.5 * (across + down);
  constexpr double kDistance_m = 10;
  Scene scene;
  scene.meshes.push_back(
      {{Rectangle((kDistance_m * corner).cast<float>(), (kDistance_m * across).cast<float>(),
                  (kDistance_m * down).cast<float>(), Material::kCarPaint, 3)}});
  scene.instances.push_back({});
  scene.light.sky = false;
  return scene;
}

Eigen::Vector2d CentreOf(const cv::Mat& picture) {
  const cv::Mat grey = picture;
  double sum = 0;
  Eigen::Vector2d centre(0, 0);
  for (int y = 0; y < grey.rows; ++y) {
    for (int x = 0; x < grey.cols; ++x) {
      const double level = grey.at<uint8_t>(y, x);
      sum += level;
      centre += level * Eigen::Vector2d(x, y);
    }
  }
  return centre / sum;
}

cv::Mat Draw(const Scene& scene, const LensView& view) {
  return Renderer(scene, NoiselessLens()).DrawGrey(view, Shot());
}

TEST(LensViewTest, AMarkerIsWhereTheLensHasIt) {
  for (const Case& c : Cases()) {
    const auto view = LensView::Make(c.camera, kWidth, kHeight);
    ASSERT_TRUE(view.ok()) << view.status();
    int seen = 0;
    for (int i = 0; i < 24; ++i) {
      const double off_axis = c.widest_rad * (i % 6 + 0.5) / 6;
      const double around = 0.4 + 2.4 * i;
      const Vector3d direction(std::sin(off_axis) * std::cos(around),
                               std::sin(off_axis) * std::sin(around), std::cos(off_axis));
      const auto expected = ProjectRaw(c.camera, direction);
      if (!expected.has_value()) continue;
      constexpr double kEdge_px = 8;
      if (expected->x() < kEdge_px || expected->x() > kWidth - kEdge_px ||
          expected->y() < kEdge_px || expected->y() > kHeight - kEdge_px) {
        continue;
      }
      ++seen;
      // Edges of faces are drawn in whole pixels of the cube's sides, which moves the centre of a
      // square of a few pixels by a tenth.
      const cv::Mat picture = Draw(MarkerAt(direction, 0.03), *view);
      EXPECT_LT((CentreOf(picture) - *expected).norm(), 0.15)
          << c.name << ", " << off_axis << " rad from the axis, at " << expected->transpose();
    }
    EXPECT_GE(seen, 12) << c.name;
  }
}

TEST(LensViewTest, AFisheyeSeesWhatIsBesideIt) {
  const auto view = LensView::Make(Cases()[1].camera, kWidth, kHeight);
  ASSERT_TRUE(view.ok());
  EXPECT_GE(view->sides().size(), 5u);
  // The picture's corners are more than 90 degrees from the axis, its sides are not.
  EXPECT_GT(cv::countNonZero(Draw(MarkerAt({0.8, 0.6, 0}, 0.05), *view)), 10);
  const Vector3d behind(std::sin(1.7), 0, std::cos(1.7));
  EXPECT_EQ(cv::countNonZero(Draw(MarkerAt(behind, 0.05), *view)), 0);
}

TEST(LensViewTest, IsBlackWhereTheLensSeesNothing) {
  // The model folds back at 1 / sqrt(0.6) rad: nothing falls beyond 0.86 focal lengths.
  const RawCamera camera{100, 100, 200, 150, Equidistant{-0.2, 0, 0, 0}};
  const auto view = LensView::Make(camera, kWidth, kHeight);
  ASSERT_TRUE(view.ok());
  Scene bright;
  bright.meshes.push_back(
      {{Rectangle({-40, -40, 5}, {80, 0, 0}, {0, 80, 0}, Material::kCeiling, 1)}});
  bright.instances.push_back({});
  const cv::Mat picture = Draw(bright, *view);
  EXPECT_GT(picture.at<uint8_t>(150, 200), 50);
  EXPECT_EQ(picture.at<uint8_t>(2, 2), 0);
  EXPECT_EQ(picture.at<uint8_t>(150, 300), 0);
}

TEST(LensViewTest, APinholeIsDrawnAsOne) {
  const Camera camera = {250, 250, 199.5, 149.5, kWidth, kHeight};
  const auto view = LensView::Make({250, 250, 199.5, 149.5, RadialTangential()}, kWidth, kHeight);
  ASSERT_TRUE(view.ok());
  EXPECT_EQ(view->sides().size(), 1u);
  Scene scene;
  scene.meshes.push_back({{Rectangle({-9, -9, 9}, {18, 0, 0}, {0, 18, 0}, Material::kFacade, 4)}});
  scene.instances.push_back({});
  const Renderer renderer(scene, NoiselessLens());
  cv::Mat difference;
  cv::absdiff(renderer.DrawGrey(camera, Shot()), Draw(scene, *view), difference);
  // It is nearer than half a pixel beside it would be.
  const cv::Mat drawn = renderer.DrawGrey(camera, Shot());
  cv::Mat a_pixel_aside;
  cv::absdiff(drawn.colRange(0, kWidth - 1), drawn.colRange(1, kWidth), a_pixel_aside);
  EXPECT_LT(cv::mean(difference)[0], 0.5 * cv::mean(a_pixel_aside)[0]);
}

TEST(LensViewTest, TheSameBytesWithOneThreadAndThree) {
  const auto view = LensView::Make(Cases()[2].camera, kWidth, kHeight);
  ASSERT_TRUE(view.ok());
  const Scene scene = MarkerAt({0.6, 0, 0.8}, 0.4);
  const Renderer three(scene, NoiselessLens(), 3);
  EXPECT_EQ(cv::norm(Draw(scene, *view), three.DrawGrey(*view, Shot()), cv::NORM_INF), 0);
}

TEST(LensViewTest, RefusesWhatNoCameraIs) {
  const auto says = [](const RawCamera& camera, int width) {
    return std::string(LensView::Make(camera, width, kHeight).status().message());
  };
  EXPECT_THAT(says({250, 250, 200, 150, DoubleSphere{-0.2, 2}}, kWidth), HasSubstr("alpha is 2"));
  EXPECT_THAT(says({250, 250, 200, 150, {}}, 0), HasSubstr("0x300 pixels"));
  EXPECT_THAT(says({0, 250, 200, 150, {}}, kWidth), HasSubstr("focal lengths of 0"));
}

}  // namespace
}  // namespace corbslam
