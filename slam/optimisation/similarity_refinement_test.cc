#include "slam/optimisation/similarity_refinement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "slam/geometry/lie.h"
#include "slam/optimisation/mutual_reprojection_cost.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam {
namespace {

const Similarity3d kTruth =
    ExpSim3((Vector7d() << 0.4, -0.2, 0.3, 0.05, -0.1, 0.08, 0.2).finished());

std::vector<SimilarityMatch> Matches(const Similarity3d& b_from_a, int count) {
  const Camera camera = testing::SyntheticCamera();
  std::vector<SimilarityMatch> matches;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d a(std::sin(3.1 * i) * 2, std::cos(1.7 * i), 6 + 2 * std::sin(0.9 * i));
    const Eigen::Vector3d b = b_from_a * a;
    matches.push_back({a, b, Project(camera, a), Project(camera, b), 1, 1});
  }
  return matches;
}

template <bool kInverse>
void CheckJacobian(const Rigid3d& beside) {
  const Camera camera = testing::SyntheticCamera();
  const MutualReprojectionCost<kInverse> cost(camera, {0.4, 0.3, 5}, {300, 220}, 1.7, beside);
  const SimilarityBlock block = ToBlock(kTruth);
  const LeftPerturbation<7> manifold;
  const double* parameters[1] = {block.data()};
  Eigen::Matrix<double, 2, 8, Eigen::RowMajor> J;
  double* jacobians[1] = {J.data()};
  Eigen::Vector2d residual;
  ASSERT_TRUE(cost.Evaluate(parameters, residual.data(), jacobians));
  for (int i = 0; i < 7; ++i) {
    Eigen::Vector2d sides[2];
    for (int side = 0; side < 2; ++side) {
      const Vector7d step = (side == 0 ? 1e-6 : -1e-6) * Vector7d::Unit(i);
      SimilarityBlock moved{};
      manifold.Plus(block.data(), step.data(), moved.data());
      const double* at[1] = {moved.data()};
      ASSERT_TRUE(cost.Evaluate(at, sides[side].data(), nullptr));
    }
    EXPECT_LT(((sides[0] - sides[1]) / 2e-6 - J.col(i)).norm(), 1e-5) << i;
  }
}

TEST(MutualReprojectionCostTest, JacobiansAgreeWithNumericDifferences) {
  const Rigid3d turned{ExpSO3({0.1, -0.2, 0.05}), {0.3, -0.1, 0.4}};
  for (const Rigid3d& beside : {Rigid3d::Identity(), turned}) {
    CheckJacobian<false>(beside);
    CheckJacobian<true>(beside);
  }
}

TEST(RefineSimilarityTest, FindsTheTruthBothWaysAndRejectsOutliers) {
  const Camera camera = testing::SyntheticCamera();
  const Similarity3d offset =
      ExpSim3((Vector7d() << 0.05, 0.05, -0.05, 0.01, 0.01, -0.01, 0.05).finished());
  for (const Similarity3d& truth : {kTruth, kTruth.Inverse()}) {
    auto matches = Matches(truth, 60);
    for (size_t i = 0; i < 12; ++i) matches[5 * i].pixel_in_b.x() += 40;
    const auto refined = RefineSimilarity(camera, camera, matches, offset * truth, false);
    ASSERT_TRUE(refined.ok()) << refined.status();
    EXPECT_LT(LogSim3(refined->b_from_a * truth.Inverse()).norm(), 1e-4);
    EXPECT_EQ(refined->inliers, 48);
    EXPECT_FALSE(refined->is_inlier[5]);
    EXPECT_TRUE(refined->is_inlier[6]);
  }
}

TEST(RefineSimilarityTest, KeepsAFixedScale) {
  const Camera camera = testing::SyntheticCamera();
  Similarity3d truth = kTruth;
  truth.scale = 1;
  const Similarity3d offset =
      ExpSim3((Vector7d() << 0.05, 0.05, -0.05, 0.01, 0.01, -0.01, 0).finished());
  const auto refined = RefineSimilarity(camera, camera, Matches(truth, 40), offset * truth, true);
  ASSERT_TRUE(refined.ok()) << refined.status();
  EXPECT_NEAR(refined->b_from_a.scale, 1, 1e-12);
  EXPECT_LT((refined->b_from_a.translation - truth.translation).norm(), 1e-4);
}

TEST(RefineSimilarityTest, RefusesTooFewAndNotFinite) {
  const Camera camera = testing::SyntheticCamera();
  auto matches = Matches(kTruth, 2);
  EXPECT_EQ(RefineSimilarity(camera, camera, matches, kTruth, false).status().code(),
            absl::StatusCode::kInvalidArgument);
  matches = Matches(kTruth, 10);
  matches[3].x_in_a.x() = NAN;
  EXPECT_EQ(RefineSimilarity(camera, camera, matches, kTruth, false).status().code(),
            absl::StatusCode::kInvalidArgument);
  matches = Matches(kTruth, 10);
  for (SimilarityMatch& match : matches) match.x_in_a.z() = -5;
  EXPECT_EQ(RefineSimilarity(camera, camera, matches, kTruth, false).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

// Returns the mean of the squared error of refinements of noisy pixels, in the covariance that each
// says.
double MeanChi2(bool fix_scale) {
  constexpr int kDraws = 300;
  const Camera camera = testing::SyntheticCamera();
  Similarity3d truth = kTruth;
  if (fix_scale) truth.scale = 1;
  const int size = fix_scale ? 6 : 7;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.8);
  double sum = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<SimilarityMatch> matches = Matches(truth, 40);
    for (SimilarityMatch& match : matches) {
      match.variance_a_px2 = match.variance_b_px2 = 0.8 * 0.8;
      match.pixel_in_a += Eigen::Vector2d(noise(random), noise(random));
      match.pixel_in_b += Eigen::Vector2d(noise(random), noise(random));
    }
    const auto refined = RefineSimilarity(camera, camera, matches, truth, fix_scale, 30);
    EXPECT_TRUE(refined.ok());
    const auto covariance = SimilarityCovariance(camera, camera, matches, *refined, fix_scale);
    EXPECT_TRUE(covariance.ok());
    const Eigen::VectorXd e = LogSim3(truth * refined->b_from_a.Inverse()).head(size);
    sum += e.dot(covariance->topLeftCorner(size, size).inverse() * e);
  }
  return sum / kDraws;
}

// A squared error has as its mean the number of degrees of freedom; 300 draws come within a tenth
// of it.
TEST(SimilarityCovarianceTest, IsThatOfTheErrorsThatNoiseMakes) {
  EXPECT_NEAR(MeanChi2(true), 6, 0.8);
  EXPECT_NEAR(MeanChi2(false), 7, 0.8);
}

TEST(SimilarityCovarianceTest, RefusesWhatLeavesADirectionOpen) {
  const Camera camera = testing::SyntheticCamera();
  std::vector<SimilarityMatch> matches(5, Matches(kTruth, 1)[0]);
  const SimilarityRefinement refined{kTruth, {1, 1, 1, 1, 1}, 5};
  EXPECT_EQ(SimilarityCovariance(camera, camera, matches, refined, false).status().code(),
            absl::StatusCode::kFailedPrecondition);
  const SimilarityRefinement none{kTruth, {0, 0, 0, 0, 0}, 0};
  EXPECT_EQ(SimilarityCovariance(camera, camera, matches, none, false).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

// Two cameras at one place: pictures from beside them tell the scale, a wrong one among them not.
TEST(RefineSimilarityTest, SightsTellTheScaleOfCamerasAtOnePlace) {
  const Camera camera = testing::SyntheticCamera();
  const Similarity3d truth{2.5, Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero()};
  const auto matches = Matches(truth, 40);
  std::vector<SimilaritySight> sights;
  const Rigid3d beside_a{Eigen::Quaterniond::Identity(), {0.3, 0, 0}};
  const Rigid3d beside_b{Eigen::Quaterniond::Identity(), {-0.5, 0.1, 0}};
  for (size_t i = 0; i < matches.size(); ++i) {
    sights.push_back({i, false, &camera, beside_a, Project(camera, beside_a * matches[i].x_in_a)});
    sights.push_back({i, true, &camera, beside_b, Project(camera, beside_b * matches[i].x_in_b)});
  }
  for (size_t i = 0; i < sights.size(); i += 10) sights[i].pixel.x() += 30;
  Similarity3d initial = truth;
  initial.scale *= 1.4;
  const auto refined = RefineSimilarity(camera, camera, matches, initial, false, 9.21, sights);
  ASSERT_TRUE(refined.ok()) << refined.status();
  EXPECT_NEAR(refined->b_from_a.scale, 2.5, 1e-3);
  const auto covariance = SimilarityCovariance(camera, camera, matches, *refined, false, sights);
  ASSERT_TRUE(covariance.ok());
  EXPECT_LT(std::sqrt((*covariance)(6, 6)), 0.01);
  const auto alone = SimilarityCovariance(camera, camera, matches, *refined, false);
  EXPECT_TRUE(!alone.ok() || (*alone)(6, 6) > 1);
}

TEST(RefineSimilarityTest, RefusesSightsOfNoMatch) {
  const Camera camera = testing::SyntheticCamera();
  const auto matches = Matches(kTruth, 10);
  const std::vector<SimilaritySight> sights = {{10, true, &camera, Rigid3d::Identity(), {1, 2}}};
  EXPECT_EQ(RefineSimilarity(camera, camera, matches, kTruth, false, 9.21, sights).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace corbslam
