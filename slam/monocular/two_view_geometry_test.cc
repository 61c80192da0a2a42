#include "slam/monocular/two_view_geometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "slam/camera/testing/test_camera.h"
#include "slam/geometry/lie.h"

namespace corbslam {
namespace {

enum class Scene { kGeneral, kPlane, kFloor, kFar };

struct Views {
  std::vector<TwoViewMatch> matches;
  std::vector<Eigen::Vector3d> points;  // In camera 1.
  std::vector<char> is_outlier;
};

Camera OneCamera() {
  Camera camera = *testing::TestCamera();
  camera.baseline_m = 0;
  return camera;
}

// Draws matches of points that both pictures show, with noise, some of them wrong.
class SceneTest : public ::testing::Test {
 protected:
  Eigen::Vector3d PointOf(Scene scene, double x_px, double y_px) {
    std::uniform_real_distribution<double> depth(3, 12);
    switch (scene) {
      case Scene::kGeneral:
        return Unproject(camera_, x_px, y_px, depth(random_));
      case Scene::kPlane:
        // A wall at 5, turned by some 20 degrees.
        return Unproject(camera_, x_px, y_px, 5 / (1 - 0.35 * (x_px - 320) / 500));
      case Scene::kFloor:
        return Unproject(camera_, x_px, y_px, 1.5 * 500 / (y_px - 240 + 300));
      case Scene::kFar:
        return Unproject(camera_, x_px, y_px, 100 * depth(random_));
    }
    return Eigen::Vector3d::Zero();
  }

  Views See(Scene scene, const Rigid3d& two_from_one, size_t count = 300, double noise_px = 0.5,
            double outliers = 0) {
    std::uniform_real_distribution<double> x(0, 640);
    std::uniform_real_distribution<double> y(0, 480);
    std::uniform_real_distribution<double> chance(0, 1);
    std::normal_distribution<double> noise(0, noise_px);
    Views views;
    while (views.matches.size() < count) {
      const Eigen::Vector3d point = PointOf(scene, x(random_), y(random_));
      const Eigen::Vector3d moved = two_from_one * point;
      if (moved.z() < 0.5) continue;
      const Eigen::Vector2d seen = Project(camera_, moved);
      if (!IsInImage(camera_, seen)) continue;
      TwoViewMatch match;
      // Keypoints of coarser levels are noisier.
      const double scale = std::pow(1.2, levels_ > 1 ? static_cast<int>(random_() % levels_) : 0);
      match.variance_px2 = scale * scale;
      const auto noise_of = [&]() -> Eigen::Vector2d {
        return scale * Eigen::Vector2d(noise(random_), noise(random_));
      };
      match.pixel_1 = Project(camera_, point) + noise_of();
      match.pixel_2 = seen + noise_of();
      const bool is_outlier = chance(random_) < outliers;
      if (is_outlier) match.pixel_2 = {x(random_), y(random_)};
      views.matches.push_back(match);
      views.points.push_back(point);
      views.is_outlier.push_back(is_outlier ? 1 : 0);
    }
    return views;
  }

  TwoViewGeometry Find(const Views& views) {
    return FindTwoViewGeometry(camera_, views.matches, {.seed = 3});
  }

  // The motion is right but for its length, and points lie where they are, but for the same.
  static void ExpectFound(const TwoViewGeometry& found, const Views& views, const Rigid3d& truth,
                          double within_rad) {
    ASSERT_EQ(found.verdict, TwoViewVerdict::kFound);
    EXPECT_NEAR(found.two_from_one.translation.norm(), 1, 1e-9);
    EXPECT_LT(RotationAngle(found.two_from_one.rotation.conjugate() * truth.rotation), within_rad);
    const double cosine =
        found.two_from_one.translation.dot(truth.translation) / truth.translation.norm();
    EXPECT_GT(cosine, std::cos(5 * within_rad));
    ASSERT_EQ(found.points.size(), views.matches.size());
    int right = 0;
    int wrong = 0;
    for (size_t i = 0; i < found.points.size(); ++i) {
      if (!found.points[i].has_value()) continue;
      const Eigen::Vector3d x = found.points[i]->x_in_1 * truth.translation.norm();
      const bool is_right = (x - views.points[i]).norm() < 0.25 * views.points[i].norm();
      ++(is_right && !views.is_outlier[i] ? right : wrong);
    }
    EXPECT_GE(right, 50);
    EXPECT_LT(wrong, 0.1 * right);
  }

  const Camera camera_ = OneCamera();
  std::mt19937 random_{11};
  uint32_t levels_ = 1;
};

const Rigid3d kAside = {ExpSO3({0.01, -0.04, 0.02}), {-0.5, 0.05, 0.1}};
const Rigid3d kForward = {ExpSO3({0.005, 0.01, 0}), {0.05, 0, -1.0}};

TEST_F(SceneTest, FindsTheMotionInAGeneralScene) {
  const Views views = See(Scene::kGeneral, kAside);
  const TwoViewGeometry found = Find(views);
  ExpectFound(found, views, kAside, 0.01);
  EXPECT_FALSE(found.is_planar);
}

TEST_F(SceneTest, FindsAMotionForward) {
  const Views views = See(Scene::kGeneral, kForward);
  ExpectFound(Find(views), views, kForward, 0.01);
}

TEST_F(SceneTest, FindsTheMotionBeforeAWall) {
  const Views views = See(Scene::kPlane, kAside);
  const TwoViewGeometry found = Find(views);
  ExpectFound(found, views, kAside, 0.02);
  EXPECT_TRUE(found.is_planar);
  EXPECT_GT(found.homography_share, 0.45);
}

TEST_F(SceneTest, FindsTheMotionAboveAFloor) {
  const Views views = See(Scene::kFloor, kAside);
  ExpectFound(Find(views), views, kAside, 0.02);
}

TEST_F(SceneTest, AThirdOfWrongMatchesDoesNotMatter) {
  for (const Scene scene : {Scene::kGeneral, Scene::kPlane}) {
    const Views views = See(scene, kAside, 300, 0.5, 0.35);
    ExpectFound(Find(views), views, kAside, 0.02);
  }
}

TEST_F(SceneTest, IsTheSameForTheSameSeed) {
  const Views views = See(Scene::kGeneral, kAside, 300, 0.5, 0.3);
  const TwoViewGeometry once = Find(views);
  const TwoViewGeometry again = Find(views);
  EXPECT_EQ(once.two_from_one.translation, again.two_from_one.translation);
  EXPECT_EQ(once.two_from_one.rotation.coeffs(), again.two_from_one.rotation.coeffs());
}

TEST_F(SceneTest, RefusesACameraThatTurnsOnTheSpot) {
  for (const double angle : {0.02, 0.1, 0.25}) {
    for (const Scene scene : {Scene::kGeneral, Scene::kPlane}) {
      for (const double outliers : {0.0, 0.3}) {
        const Rigid3d turn = {ExpSO3({0, angle, 0.3 * angle}), Eigen::Vector3d::Zero()};
        const TwoViewGeometry found = Find(See(scene, turn, 300, 0.7, outliers));
        EXPECT_NE(found.verdict, TwoViewVerdict::kFound) << angle << " " << outliers;
        if (outliers > 0) continue;
        EXPECT_EQ(found.verdict, TwoViewVerdict::kLittleParallax) << angle;
      }
    }
  }
}

TEST_F(SceneTest, CoarseKeypointsAreNoParallax) {
  levels_ = 8;
  for (int i = 0; i < 20; ++i) {
    const Rigid3d turn = {ExpSO3({0.01 * i, 0.1, -0.02}), Eigen::Vector3d::Zero()};
    EXPECT_NE(Find(See(i % 2 == 0 ? Scene::kGeneral : Scene::kPlane, turn, 1500, 1.0)).verdict,
              TwoViewVerdict::kFound)
        << i;
  }
  const Views views = See(Scene::kGeneral, kAside, 1500, 0.8, 0.2);
  ExpectFound(Find(views), views, kAside, 0.01);
}

TEST_F(SceneTest, RefusesACameraThatStandsStill) {
  for (const double noise_px : {0.0, 0.3, 1.0}) {
    for (const double outliers : {0.0, 0.2}) {
      const TwoViewGeometry found =
          Find(See(Scene::kGeneral, Rigid3d::Identity(), 300, noise_px, outliers));
      EXPECT_NE(found.verdict, TwoViewVerdict::kFound) << noise_px << " " << outliers;
    }
  }
}

TEST_F(SceneTest, RefusesTooShortAMotion) {
  const Rigid3d nudge = {ExpSO3({0, 0.03, 0}), {0.02, 0, 0}};
  EXPECT_EQ(Find(See(Scene::kGeneral, nudge)).verdict, TwoViewVerdict::kLittleParallax);
  EXPECT_EQ(Find(See(Scene::kFar, kAside)).verdict, TwoViewVerdict::kLittleParallax);
  EXPECT_LT(Find(See(Scene::kFar, kAside)).parallax_rad, 0.01745);
}

TEST_F(SceneTest, RefusesTooFewMatches) {
  EXPECT_EQ(Find(See(Scene::kGeneral, kAside, 49)).verdict, TwoViewVerdict::kFewMatches);
  EXPECT_EQ(Find({}).verdict, TwoViewVerdict::kFewMatches);
  EXPECT_EQ(FindTwoViewGeometry(camera_, See(Scene::kGeneral, kAside, 7).matches, {.min_points = 3})
                .verdict,
            TwoViewVerdict::kFewMatches);
}

TEST_F(SceneTest, RefusesMatchesOfChance) {
  EXPECT_NE(Find(See(Scene::kGeneral, kAside, 300, 0.5, 1.0)).verdict, TwoViewVerdict::kFound);
}

// Anything may be drawn: what is found is right, or nothing is.
TEST_F(SceneTest, IsRightOrRefuses) {
  std::uniform_real_distribution<double> turn(-0.1, 0.1);
  std::uniform_real_distribution<double> move(-0.6, 0.6);
  int found_motions = 0;
  for (int i = 0; i < 60; ++i) {
    const Rigid3d truth = {ExpSO3({turn(random_), turn(random_), turn(random_)}),
                           {move(random_), move(random_), move(random_)}};
    const auto scene = static_cast<Scene>(i % 3);
    const Views views = See(scene, truth, 250, 0.6, 0.2);
    const TwoViewGeometry found = Find(views);
    if (found.verdict != TwoViewVerdict::kFound) continue;
    ++found_motions;
    ExpectFound(found, views, truth, 0.03);
  }
  EXPECT_GE(found_motions, 25);
}

}  // namespace
}  // namespace corbslam
