// Time of pose optimisation, local and global bundle adjustment on synthetic scenes.
#include <benchmark/benchmark.h>

#include <utility>
#include <vector>

#include "slam/optimisation/bundle_adjustment.h"
#include "slam/optimisation/pose_optimisation.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam {
namespace {

testing::SyntheticScene MakeScene(int keyframes, int points) {
  testing::SyntheticSceneOptions options;
  options.keyframes = keyframes;
  options.points = points;
  options.step_m = 0.35;
  options.max_observations_per_point = 5;
  options.share_with_depth = 0.8;
  options.pixel_noise_px = 0.7;
  options.share_of_outliers = 0.03;
  options.pose_noise_m = 0.05;
  options.pose_noise_rad = 0.01;
  options.point_noise_m = 0.1;
  return testing::MakeSyntheticScene(options);
}

size_t CountObservations(const Map& map) {
  size_t count = 0;
  for (const auto& [id, point] : map.points()) count += point.observations.size();
  return count;
}

// Arguments: keyframes, points, threads, iterations a round.
void BM_AdjustBundle(benchmark::State& state) {
  const auto scene = MakeScene(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  const BundleScope scope = GlobalBundleScope(scene.map, {});
  BundleOptions options;
  options.threads = static_cast<int>(state.range(2));
  options.max_iterations = static_cast<int>(state.range(3));
  for (auto _ : state) {
    const auto result = AdjustBundle(scene.map, scope, options);
    state.counters["iterations"] = result->iterations;
    benchmark::DoNotOptimize(result);
  }
  state.counters["observations"] = static_cast<double>(CountObservations(scene.map));
}
BENCHMARK(BM_AdjustBundle)
    ->Args({20, 2000, 1, 5})
    ->Args({64, 10000, 1, 10})
    ->Args({64, 10000, 2, 10})
    ->Args({500, 60000, 2, 10})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void BM_OptimisePose(benchmark::State& state) {
  const auto scene = MakeScene(2, 2600);
  const Keyframe& keyframe = scene.map.keyframes().rbegin()->second;
  std::vector<PoseObservation> observations;
  for (size_t i = 0; i < keyframe.points.size() && i < 1000; ++i) {
    const Keypoint& keypoint = keyframe.keypoints()[i];
    observations.push_back({scene.true_position_in_map.at(keyframe.points[i]), keypoint.Pixel(),
                            keypoint.disparity_px, ScalePyramid::Variance_px2(keypoint.octave)});
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(OptimisePose(scene.camera, keyframe.camera_from_map, observations));
  }
  state.counters["observations"] = static_cast<double>(observations.size());
}
BENCHMARK(BM_OptimisePose)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace corbslam

BENCHMARK_MAIN();
