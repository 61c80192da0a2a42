#include "slam/monocular/two_view_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "slam/geometry/lie.h"

namespace corbslam {
namespace {

const Rigid3d kMotion = {ExpSO3({0.05, -0.1, 0.02}), Eigen::Vector3d(0.6, -0.1, 0.2).normalized()};

std::vector<NormalisedMatch> See(const std::vector<Eigen::Vector3d>& points) {
  std::vector<NormalisedMatch> matches;
  for (const Eigen::Vector3d& x : points) {
    const Eigen::Vector3d moved = kMotion * x;
    matches.push_back({x.head<2>() / x.z(), moved.head<2>() / moved.z(), 1e-6});
  }
  return matches;
}

// Points of the plane z = 4 + 0.3 x, or anywhere before the camera.
std::vector<Eigen::Vector3d> Scatter(bool planar, size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> at(-2, 2);
  std::vector<Eigen::Vector3d> points;
  for (size_t i = 0; i < count; ++i) {
    const double x = at(random);
    const double y = at(random);
    points.emplace_back(x, y, planar ? 4 + 0.3 * x : 6 + at(random));
  }
  return points;
}

bool HasMotion(const std::vector<Rigid3d>& motions) {
  return std::any_of(motions.begin(), motions.end(), [](const Rigid3d& motion) {
    return RotationAngle(motion.rotation.conjugate() * kMotion.rotation) < 1e-5 &&
           (motion.translation - kMotion.translation).norm() < 1e-5;
  });
}

TEST(TwoViewModelsTest, AHomographyExplainsAPlaneAndHoldsItsMotion) {
  const std::vector<NormalisedMatch> matches = See(Scatter(/*planar=*/true, 20));
  const auto H = FitHomography(matches);
  ASSERT_TRUE(H.has_value());
  const ModelScore score = ScoreHomography(*H, matches);
  EXPECT_EQ(std::count(score.is_inlier.begin(), score.is_inlier.end(), 1), 20);
  EXPECT_NEAR(score.score, 20 * 2 * 5.99, 1e-3);
  EXPECT_TRUE(HasMotion(MotionsOfHomography(*H)));
  EXPECT_TRUE(HasMotion(MotionsOfHomography(-2.5 * *H))) << "its sign and size mean nothing";
}

TEST(TwoViewModelsTest, AnEssentialMatrixExplainsAnythingAndHoldsItsMotion) {
  const std::vector<NormalisedMatch> matches = See(Scatter(/*planar=*/false, 20));
  const auto E = FitEssential(matches);
  ASSERT_TRUE(E.has_value());
  const ModelScore score = ScoreEssential(*E, matches);
  EXPECT_EQ(std::count(score.is_inlier.begin(), score.is_inlier.end(), 1), 20);
  EXPECT_NEAR(score.score, 20 * 2 * 5.99, 1e-3);
  EXPECT_EQ(MotionsOfEssential(*E).size(), 4U);
  EXPECT_TRUE(HasMotion(MotionsOfEssential(*E)));
  // A plane does not explain them.
  const auto H = FitHomography(matches);
  ASSERT_TRUE(H.has_value());
  EXPECT_LT(ScoreHomography(*H, matches).score, 0.7 * score.score);
}

TEST(TwoViewModelsTest, ARotationHasNoMotion) {
  EXPECT_TRUE(MotionsOfHomography(ExpSO3({0.1, 0.2, 0}).toRotationMatrix()).empty());
}

TEST(TwoViewModelsTest, PointsThatDetermineNothingGiveNoModel) {
  const std::vector<NormalisedMatch> same(8, {Eigen::Vector2d(0.1, 0.2), {0.3, 0.1}, 1e-6});
  EXPECT_FALSE(FitHomography(same).has_value());
  EXPECT_FALSE(FitEssential(same).has_value());
  std::vector<NormalisedMatch> on_line;
  for (int i = 0; i < 8; ++i) on_line.push_back({{0.1 * i, 0}, {0.1 * i + 0.05, 0}, 1e-6});
  EXPECT_FALSE(FitHomography(on_line).has_value());
}

TEST(TwoViewModelsTest, AnOutlierCostsWhatItWouldHaveGiven) {
  std::vector<NormalisedMatch> matches = See(Scatter(/*planar=*/false, 20));
  const auto E = FitEssential(matches);
  ASSERT_TRUE(E.has_value());
  matches[3].x_2 += Eigen::Vector2d(0.1, 0.1);
  const ModelScore score = ScoreEssential(*E, matches);
  EXPECT_FALSE(score.is_inlier[3]);
  EXPECT_NEAR(score.score, 19 * 2 * 5.99, 1e-3);
}

}  // namespace
}  // namespace corbslam
