// Measures the time of local and global bundle adjustment on synthetic scenes, by both solvers.
#include <benchmark/benchmark.h>

#include <string>
#include <utility>
#include <vector>

#include "slam/optimisation/bundle_adjustment.h"
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

// The arguments are keyframes, points, threads and solver.
void BM_AdjustBundle(benchmark::State& state) {
  const auto scene = MakeScene(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  const BundleScope scope = GlobalBundleScope(scene.map, {});
  BundleOptions options;
  options.threads = static_cast<int>(state.range(2));
  options.solver = static_cast<BundleSolver>(state.range(3));
  for (auto _ : state) {
    const auto result = AdjustBundle(scene.map, scope, options);
    if (!result.ok()) {
      state.SkipWithError(std::string(result.status().message()).c_str());
      break;
    }
    state.counters["iterations"] = result->iterations;
    state.counters["final_cost"] = result->final_cost;
  }
  state.counters["observations"] = static_cast<double>(testing::CountObservations(scene.map));
  state.SetLabel(options.solver == BundleSolver::kCeres ? "Ceres" : "block Schur");
}
void Sizes(benchmark::internal::Benchmark* benchmark) {
  for (const auto& [keyframes, points] : {std::pair(20, 2000), {64, 10000}, {500, 60000}}) {
    for (const int threads : {1, 2}) {
      for (const BundleSolver solver : {BundleSolver::kBlockSchur, BundleSolver::kCeres}) {
        benchmark->Args({keyframes, points, threads, static_cast<int>(solver)});
      }
    }
  }
}
BENCHMARK(BM_AdjustBundle)->Apply(Sizes)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace corbslam

BENCHMARK_MAIN();
