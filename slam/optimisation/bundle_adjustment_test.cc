#include "slam/optimisation/bundle_adjustment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "slam/geometry/lie.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;
using testing::MakeSyntheticScene;
using testing::SyntheticScene;
using testing::SyntheticSceneOptions;

SyntheticSceneOptions Disturbed() {
  SyntheticSceneOptions options;
  options.pose_noise_m = 0.05;
  options.pose_noise_rad = 0.01;
  options.point_noise_m = 0.1;
  return options;
}

double WorstPoseError(const SyntheticScene& scene, const BundleResult& result) {
  double worst = 0;
  for (const PoseUpdate& pose : result.poses) {
    worst = std::max(
        worst,
        LogSE3(pose.camera_from_map * scene.true_camera_from_map.at(pose.id).Inverse()).norm());
  }
  return worst;
}

class AdjustBundleTest : public ::testing::TestWithParam<BundleSolver> {
 protected:
  static BundleOptions Options(int max_iterations = BundleOptions().max_iterations) {
    BundleOptions options;
    options.max_iterations = max_iterations;
    options.solver = GetParam();
    return options;
  }
};
INSTANTIATE_TEST_SUITE_P(Solvers, AdjustBundleTest,
                         ::testing::Values(BundleSolver::kBlockSchur, BundleSolver::kCeres),
                         [](const auto& solver) {
                           return solver.param == BundleSolver::kCeres ? "Ceres" : "BlockSchur";
                         });

TEST_P(AdjustBundleTest, FindsTheTruthFromExactPixels) {
  const SyntheticScene scene = MakeSyntheticScene(Disturbed());
  const auto result = AdjustBundle(scene.map, GlobalBundleScope(scene.map, {}), Options(30));
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->poses.size(), scene.map.keyframes().size() - 1);
  EXPECT_LT(WorstPoseError(scene, *result), 1e-4);
  EXPECT_LT(result->final_cost, 1e-3 * result->initial_cost);
  EXPECT_TRUE(result->outliers.empty());
}

TEST_P(AdjustBundleTest, AShiftedMapGivesTheShiftedResult) {
  SyntheticScene scene = MakeSyntheticScene(Disturbed());
  const auto result = AdjustBundle(scene.map, GlobalBundleScope(scene.map, {}), Options());
  const Rigid3d shift{ExpSO3({0.3, -0.7, 1.1}), {100, -50, 20}};
  Map shifted = scene.map;
  for (const auto& [id, keyframe] : scene.map.keyframes()) {
    shifted.SetPose(id, keyframe.camera_from_map * shift.Inverse());
  }
  for (const auto& [id, point] : scene.map.points()) {
    shifted.SetPosition(id, shift * point.position_in_map);
  }
  const auto moved = AdjustBundle(shifted, GlobalBundleScope(shifted, {}), Options());
  ASSERT_TRUE(result.ok() && moved.ok());
  for (size_t i = 0; i < result->poses.size(); ++i) {
    const Rigid3d back = moved->poses[i].camera_from_map * shift;
    EXPECT_LT((back.translation - result->poses[i].camera_from_map.translation).norm(), 1e-3);
  }
}

TEST_P(AdjustBundleTest, RejectsOutliersAndStaysAccurate) {
  SyntheticSceneOptions scene_options = Disturbed();
  scene_options.pixel_noise_px = 0.5;
  scene_options.share_of_outliers = 0.05;
  const SyntheticScene scene = MakeSyntheticScene(scene_options);
  const auto result = AdjustBundle(scene.map, GlobalBundleScope(scene.map, {}), Options(15));
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_LT(WorstPoseError(scene, *result), 0.03);
  size_t found = 0;
  for (const auto& [point, keyframe] : scene.outliers) {
    const ObservationKey key{point, keyframe};
    found += std::binary_search(result->outliers.begin(), result->outliers.end(), key) ? 1 : 0;
  }
  EXPECT_GT(found, scene.outliers.size() * 9 / 10);
  EXPECT_LT(result->outliers.size(), scene.outliers.size() * 3 / 2);
}

// The errors are far beyond the noise that keypoints have, yet within what is assumed of them.
TEST_P(AdjustBundleTest, MeasuredNoiseKeepsFalseDepthsOut) {
  SyntheticSceneOptions scene_options = Disturbed();
  scene_options.keyframes = 20;
  scene_options.max_observations_per_point = 4;
  scene_options.pixel_noise_px = 0.2;
  scene_options.share_of_false_depths = 0.15;
  const SyntheticScene scene = MakeSyntheticScene(scene_options);
  BundleOptions options = Options(30);
  const BundleScope scope = GlobalBundleScope(scene.map, {});
  const auto assumed = AdjustBundle(scene.map, scope, options);
  options.measure_noise = true;
  const auto measured = AdjustBundle(scene.map, scope, options);
  ASSERT_TRUE(assumed.ok()) << assumed.status();
  ASSERT_TRUE(measured.ok()) << measured.status();
  EXPECT_LT(WorstPoseError(scene, *measured), 0.5 * WorstPoseError(scene, *assumed));
  // They are left out, but not called false matches.
  EXPECT_LT(measured->outliers.size(), testing::CountObservations(scene.map) / 20);
}

// Where two sightings disagree by more than noise, both are left out; but they stay in the map, and
// so the point is not left behind.
TEST_P(AdjustBundleTest, EveryPointThatIsStillSeenIsTold) {
  SyntheticSceneOptions scene_options = Disturbed();
  scene_options.max_observations_per_point = 2;
  scene_options.pixel_noise_px = 0.1;
  scene_options.share_of_false_depths = 0.1;
  const SyntheticScene scene = MakeSyntheticScene(scene_options);
  BundleOptions options = Options(30);
  options.measure_noise = true;
  const auto result = AdjustBundle(scene.map, GlobalBundleScope(scene.map, {}), options);
  ASSERT_TRUE(result.ok()) << result.status();
  std::set<MapPointId> told;
  for (const PositionUpdate& update : result->positions) told.insert(update.id);
  for (const auto& [id, point] : scene.map.points()) {
    size_t kept = 0;
    for (const auto& [keyframe, keypoint] : point.observations) {
      kept += std::ranges::binary_search(result->outliers, ObservationKey{id, keyframe}) ? 0 : 1;
    }
    EXPECT_TRUE(kept < 2 || told.contains(id)) << ToString(id);
  }
}

TEST_P(AdjustBundleTest, MonocularMapKeepsItsReprojectionSmall) {
  SyntheticSceneOptions scene_options = Disturbed();
  scene_options.share_with_depth = 0;
  const SyntheticScene scene = MakeSyntheticScene(scene_options);
  const auto result = AdjustBundle(scene.map, GlobalBundleScope(scene.map, {}), Options(40));
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_LT(result->final_cost, 1e-3 * result->initial_cost);
}

double ExtentOf(const std::map<KeyframeId, Rigid3d>& poses) {
  double sum2 = 0;
  for (const auto& [id, pose] : poses) {
    sum2 += (CameraCentre(pose) - CameraCentre(poses.begin()->second)).squaredNorm();
  }
  return std::sqrt(sum2);
}

TEST_P(AdjustBundleTest, MonocularMapStaysAsLargeAsItWas) {
  SyntheticSceneOptions scene_options = Disturbed();
  scene_options.share_with_depth = 0;
  const SyntheticScene scene = MakeSyntheticScene(scene_options);
  const BundleScope scope = GlobalBundleScope(scene.map, {});
  const auto result = AdjustBundle(scene.map, scope, Options(40));
  ASSERT_TRUE(result.ok()) << result.status();
  std::map<KeyframeId, Rigid3d> before;
  for (const auto& [id, keyframe] : scene.map.keyframes()) before[id] = keyframe.camera_from_map;
  std::map<KeyframeId, Rigid3d> after = before;
  for (const PoseUpdate& pose : result->poses) after[pose.id] = pose.camera_from_map;
  EXPECT_NEAR(ExtentOf(after) / ExtentOf(before), 1, 1e-9);
  // It is the truth but for that size.
  const double scale = ExtentOf(scene.true_camera_from_map) / ExtentOf(after);
  for (const auto& [id, truth] : scene.true_camera_from_map) {
    EXPECT_LT((scale * CameraCentre(after[id]) - CameraCentre(truth)).norm(), 0.01) << ToString(id);
  }
}

TEST_P(AdjustBundleTest, WhereADepthIsMeasuredTheSizeIsToo) {
  SyntheticSceneOptions scene_options = Disturbed();
  scene_options.share_with_depth = 0.5;
  SyntheticScene scene = MakeSyntheticScene(scene_options);
  for (const auto& [id, pose] : scene.true_camera_from_map) {
    Rigid3d larger = pose;
    larger.translation *= 1.1;
    scene.map.SetPose(id, larger);
  }
  for (const auto& [id, position] : scene.true_position_in_map) {
    scene.map.SetPosition(id, 1.1 * position);
  }
  const auto result = AdjustBundle(scene.map, GlobalBundleScope(scene.map, {}), Options(40));
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_LT(WorstPoseError(scene, *result), 0.02);
}

TEST_P(AdjustBundleTest, SparseSystemAgreesWithTheTruthToo) {
  SyntheticSceneOptions scene_options = Disturbed();
  scene_options.keyframes = 80;
  scene_options.points = 3000;
  scene_options.max_observations_per_point = 5;
  const SyntheticScene scene = MakeSyntheticScene(scene_options);
  const auto result = AdjustBundle(scene.map, GlobalBundleScope(scene.map, {}), Options(30));
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_LT(WorstPoseError(scene, *result), 1e-2)
      << result->iterations << " iterations, cost " << result->initial_cost << " to "
      << result->final_cost << ", outliers " << result->outliers.size();
}

TEST_P(AdjustBundleTest, TheSameInputGivesTheSameBitsAndThreadsHardlyMatter) {
  const SyntheticScene scene = MakeSyntheticScene(Disturbed());
  const BundleScope scope = GlobalBundleScope(scene.map, {});
  BundleOptions options = Options();
  const auto first = AdjustBundle(scene.map, scope, options);
  const auto second = AdjustBundle(scene.map, scope, options);
  options.threads = 2;
  const auto threaded = AdjustBundle(scene.map, scope, options);
  ASSERT_TRUE(first.ok() && second.ok() && threaded.ok());
  for (size_t i = 0; i < first->poses.size(); ++i) {
    const Eigen::Vector3d t = first->poses[i].camera_from_map.translation;
    EXPECT_EQ(t, second->poses[i].camera_from_map.translation);
    EXPECT_LT((t - threaded->poses[i].camera_from_map.translation).norm(), 1e-5);
  }
}

TEST_P(AdjustBundleTest, KeepGoingSeesProgressAndCancels) {
  const SyntheticScene scene = MakeSyntheticScene(Disturbed());
  BundleOptions options = Options();
  int calls = 0;
  double last = 0;
  options.keep_going = [&](double progress) {
    EXPECT_GE(progress, last);
    EXPECT_LE(progress, 1);
    last = progress;
    return ++calls < 2;
  };
  const auto result = AdjustBundle(scene.map, GlobalBundleScope(scene.map, {}), options);
  ASSERT_TRUE(result.ok());
  EXPECT_TRUE(result->cancelled);
  EXPECT_EQ(calls, 2);
  EXPECT_LT(result->final_cost, result->initial_cost);
}

TEST_P(AdjustBundleTest, RefusesImpossibleScopesAndNamesTheId) {
  const SyntheticScene scene = MakeSyntheticScene({});
  const BundleScope good = GlobalBundleScope(scene.map, {});
  EXPECT_EQ(AdjustBundle(scene.map, {}, Options()).status().code(),
            absl::StatusCode::kInvalidArgument);

  BundleScope scope = good;
  scope.free_keyframes.push_back({LocalMapId{0xabc}, 7});
  absl::Status status = AdjustBundle(scene.map, scope, Options()).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("0000000000000abc:7"));

  scope = good;
  scope.fixed_points.push_back(scope.free_points[3]);
  status = AdjustBundle(scene.map, scope, Options()).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr(ToString(scope.free_points[3])));

  scope = good;
  scope.fixed_keyframes.clear();
  EXPECT_EQ(AdjustBundle(scene.map, scope, Options()).status().code(),
            absl::StatusCode::kFailedPrecondition);

  scope = good;
  scope.free_points.clear();
  EXPECT_EQ(AdjustBundle(scene.map, scope, Options()).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST_P(AdjustBundleTest, ApplyMovesTheMapAndDropsOutliers) {
  SyntheticSceneOptions scene_options = Disturbed();
  scene_options.share_of_outliers = 0.03;
  SyntheticScene scene = MakeSyntheticScene(scene_options);
  const auto result = AdjustBundle(scene.map, GlobalBundleScope(scene.map, {}), Options());
  ASSERT_TRUE(result.ok());
  ASSERT_FALSE(result->outliers.empty());
  ApplyBundle(*result, scene.map);
  const PoseUpdate& pose = result->poses.front();
  EXPECT_EQ(scene.map.FindKeyframe(pose.id)->camera_from_map.translation,
            pose.camera_from_map.translation);
  const ObservationKey& outlier = result->outliers.front();
  EXPECT_FALSE(scene.map.FindPoint(outlier.point)->observations.contains(outlier.keyframe));
}

TEST(LocalBundleScopeTest, HoldsRootAndDistantObserversAndForeignItems) {
  SyntheticSceneOptions options;
  options.keyframes = 30;
  options.points = 1500;
  options.step_m = 1;
  const SyntheticScene scene = MakeSyntheticScene(options);
  const KeyframeId centre{options.local_map, 25};
  const BundleScope scope = LocalBundleScope(scene.map, centre, options.local_map);
  EXPECT_TRUE(std::binary_search(scope.free_keyframes.begin(), scope.free_keyframes.end(), centre));
  EXPECT_FALSE(scope.fixed_keyframes.empty());
  EXPECT_TRUE(AdjustBundle(scene.map, scope, {}).ok());
  for (const KeyframeId id : scope.free_keyframes) EXPECT_NE(id.index, 0u);

  const BundleScope foreign = LocalBundleScope(scene.map, centre, LocalMapId{0xf00});
  EXPECT_TRUE(foreign.free_keyframes.empty());
  EXPECT_TRUE(foreign.free_points.empty());
  EXPECT_TRUE(LocalBundleScope(scene.map, {options.local_map, 999}, options.local_map)
                  .free_keyframes.empty());
}

TEST(GlobalBundleScopeTest, HoldsWhatIsAskedElseTheRoot) {
  const SyntheticScene scene = MakeSyntheticScene({});
  const KeyframeId third = std::next(scene.map.keyframes().begin(), 3)->first;
  EXPECT_EQ(GlobalBundleScope(scene.map, {third}).fixed_keyframes, std::vector{third});
  EXPECT_EQ(GlobalBundleScope(scene.map, {}).fixed_keyframes,
            std::vector{scene.map.keyframes().begin()->first});
}

}  // namespace
}  // namespace corbslam
