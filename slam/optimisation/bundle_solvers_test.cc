// Tests the two solvers of bundle adjustment against each other.
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <limits>
#include <random>
#include <vector>

#include "slam/geometry/lie.h"
#include "slam/optimisation/block_schur_solver.h"
#include "slam/optimisation/bundle_adjustment.h"
#include "slam/optimisation/ceres_bundle_solver.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam {
namespace {

testing::SyntheticScene NoisyScene(int keyframes, int points) {
  testing::SyntheticSceneOptions options;
  options.keyframes = keyframes;
  options.points = points;
  options.share_with_depth = 0.7;
  options.pixel_noise_px = 0.6;
  options.share_of_outliers = 0.04;
  options.pose_noise_m = 0.05;
  options.pose_noise_rad = 0.01;
  options.point_noise_m = 0.1;
  options.max_observations_per_point = 6;
  return testing::MakeSyntheticScene(options);
}

BundleOptions UntilTheMinimum(BundleSolver solver) {
  BundleOptions options;
  options.solver = solver;
  options.max_iterations = 200;
  options.converged_cost_change = 1e-15;
  options.outlier_round_cost_change = 1e-15;
  return options;
}

void ExpectTheSame(const BundleResult& a, const BundleResult& b) {
  EXPECT_NEAR(a.initial_cost, b.initial_cost, 1e-9 * a.initial_cost);
  EXPECT_NEAR(a.final_cost, b.final_cost, 1e-6 * a.final_cost);
  EXPECT_EQ(a.outliers, b.outliers);
  ASSERT_EQ(a.poses.size(), b.poses.size());
  for (size_t i = 0; i < a.poses.size(); ++i) {
    const Rigid3d& pose_a = a.poses[i].camera_from_map;
    const Rigid3d& pose_b = b.poses[i].camera_from_map;
    ASSERT_EQ(a.poses[i].id, b.poses[i].id);
    EXPECT_LT((CameraCentre(pose_a) - CameraCentre(pose_b)).norm(), 1e-6) << i;
    EXPECT_LT(pose_a.rotation.angularDistance(pose_b.rotation), 1e-7) << i;
  }
  ASSERT_EQ(a.positions.size(), b.positions.size());
  for (size_t i = 0; i < a.positions.size(); ++i) EXPECT_EQ(a.positions[i].id, b.positions[i].id);
}

void CompareSolvers(const Map& map, const BundleScope& scope) {
  const auto own = AdjustBundle(map, scope, UntilTheMinimum(BundleSolver::kBlockSchur));
  const auto ceres = AdjustBundle(map, scope, UntilTheMinimum(BundleSolver::kCeres));
  ASSERT_TRUE(own.ok()) << own.status();
  ASSERT_TRUE(ceres.ok()) << ceres.status();
  EXPECT_FALSE(own->outliers.empty());
  ExpectTheSame(*own, *ceres);
}

TEST(BundleSolversTest, ReachTheSameMinimumWithFewPoses) {
  const auto scene = NoisyScene(12, 400);
  CompareSolvers(scene.map, GlobalBundleScope(scene.map, {}));
}

// Both solve the poses' equations by a sparse factorisation here.
TEST(BundleSolversTest, ReachTheSameMinimumWithManyPoses) {
  const auto scene = NoisyScene(90, 1500);
  CompareSolvers(scene.map, GlobalBundleScope(scene.map, {}));
}

TEST(BundleSolversTest, ReachTheSameMinimumWithHeldPoints) {
  const auto scene = NoisyScene(12, 400);
  BundleScope scope = GlobalBundleScope(scene.map, {});
  const auto half = scope.free_points.begin() + std::ssize(scope.free_points) / 2;
  scope.fixed_points.assign(half, scope.free_points.end());
  scope.free_points.erase(half, scope.free_points.end());
  CompareSolvers(scene.map, scope);
}

TEST(BundleSolversTest, ReachTheSameMinimumWithPosesAlone) {
  const auto scene = NoisyScene(12, 400);
  BundleScope scope = GlobalBundleScope(scene.map, {});
  scope.fixed_points.swap(scope.free_points);
  CompareSolvers(scene.map, scope);
}

TEST(BundleSolversTest, ReachTheSameMinimumWithPointsAlone) {
  const auto scene = NoisyScene(6, 200);
  BundleScope scope = GlobalBundleScope(scene.map, {});
  scope.fixed_keyframes.insert(scope.fixed_keyframes.end(), scope.free_keyframes.begin(),
                               scope.free_keyframes.end());
  scope.free_keyframes.clear();
  CompareSolvers(scene.map, scope);
}

// The drive goes along z, with pose i at z = i, past places where some points are thought to be
// that lie ahead of all, as happens after a loop that bent the map. On their way these points come
// out from behind cameras, and are projected thousands of pixels away.
BundleProblem DrivePastPointsThatLieAhead(const Camera& camera) {
  constexpr int kPoses = 12;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  BundleProblem problem;
  problem.free_poses = kPoses - 1;
  problem.free_points = 600;
  std::vector<Eigen::Vector3d> true_points;
  for (uint32_t p = 0; p < problem.free_points; ++p) {
    const Eigen::Vector3d x(8 * uniform(random) - 4, 4 * uniform(random) - 2,
                            14 + 26 * uniform(random));
    true_points.push_back(x);
    const double ahead = p % 10 == 0 ? kPoses * uniform(random) : x.z() + 0.1 * normal(random);
    problem.points.emplace_back(x.x(), x.y(), ahead);
  }
  for (int i = 0; i < kPoses; ++i) {
    const double error = i + 1 < kPoses ? 0.05 : 0;
    problem.poses.push_back(
        {ExpSO3(Eigen::Vector3d(0, 0.1 * error * normal(random), 0)).toRotationMatrix(),
         Eigen::Vector3d(error * normal(random), 0, -i), &camera});
  }
  for (uint32_t p = 0; p < problem.free_points; ++p) {
    for (uint32_t i = 0; i < kPoses; ++i) {
      const Eigen::Vector3d x = true_points[p] - Eigen::Vector3d(0, 0, i);
      const Eigen::Vector3d pixel = ReprojectionResidual(camera, x, MakeMeasurement({0, 0}, 1, 1));
      const Eigen::Vector2d noise(0.3 * normal(random), 0.3 * normal(random));
      problem.observations.push_back(
          {i, p,
           MakeMeasurement(pixel.head<2>() + noise, camera.fx_px * camera.baseline_m / x.z(), 1),
           true});
    }
  }
  return problem;
}

void ExpectDriveAlongZ(const BundleProblem& problem) {
  for (size_t i = 0; i < problem.poses.size(); ++i) {
    const BundlePose& pose = problem.poses[i];
    const Eigen::Vector3d centre = -pose.R.transpose() * pose.t;
    EXPECT_LT((centre - Eigen::Vector3d(0, 0, static_cast<double>(i))).norm(), 0.02) << i;
  }
}

TEST(BundleSolversTest, PointsBehindCamerasBarNobodysWay) {
  const Camera camera = testing::SyntheticCamera();
  const BundleProblem problem = DrivePastPointsThatLieAhead(camera);
  MinimiseOptions options;
  options.max_iterations = 60;
  BundleProblem own = problem;
  BlockSchurSolver(options.threads, own).Minimise(options);
  ExpectDriveAlongZ(own);
  BundleProblem ceres = problem;
  ASSERT_TRUE(MinimiseWithCeres(options, ceres).ok());
  ExpectDriveAlongZ(ceres);
}

TEST(BlockSchurSolverTest, WhatIsNotUsedInALaterRoundSaysNothing) {
  const Camera camera = testing::SyntheticCamera();
  BundleProblem problem = DrivePastPointsThatLieAhead(camera);
  MinimiseOptions options;
  options.converged_cost_change = 1e-15;
  options.max_iterations = 100;
  BlockSchurSolver solver(options.threads, problem);
  solver.Minimise(options);
  for (size_t i = 0; i < problem.observations.size(); ++i) {
    problem.observations[i].is_used = i % 7 != 0;
  }
  BundleProblem without = problem;
  std::erase_if(without.observations, [](const BundleObservation& o) { return !o.is_used; });
  options.robust = false;
  const MinimiseSummary again = solver.Minimise(options);
  const MinimiseSummary fresh = BlockSchurSolver(options.threads, without).Minimise(options);
  EXPECT_NEAR(again.initial_cost, fresh.initial_cost, 1e-9 * fresh.initial_cost);
  EXPECT_NEAR(again.final_cost, fresh.final_cost, 1e-9 * fresh.final_cost);
  for (size_t i = 0; i < problem.poses.size(); ++i) {
    EXPECT_LT((problem.poses[i].t - without.poses[i].t).norm(), 1e-6) << i;
  }
}

TEST(CeresBundleSolverTest, SaysWhereAValueIsNotFiniteAndMovesNothing) {
  const Camera camera = testing::SyntheticCamera();
  BundleProblem problem;
  problem.poses = {{Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero(), &camera}};
  problem.points = {Eigen::Vector3d(0, 0, 5)};
  problem.free_points = 1;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  problem.observations = {{0, 0, MakeMeasurement({nan, 200}, 5, 1), true}};
  EXPECT_EQ(MinimiseWithCeres({}, problem).status().code(), absl::StatusCode::kInternal);
  EXPECT_EQ(problem.points[0], Eigen::Vector3d(0, 0, 5));
  problem.observations[0].is_used = false;
  EXPECT_TRUE(MinimiseWithCeres({}, problem).ok());
}

}  // namespace
}  // namespace corbslam
