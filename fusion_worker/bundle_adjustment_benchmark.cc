// Measures the global bundle adjustment of 64 keyframes.
#include <benchmark/benchmark.h>

#include "fusion_worker/local_fusion_worker.h"
#include "slam/verification/testing/synthetic_world.h"

namespace corbslam::fusion_worker {
namespace {

void BM_AdjustBundle(benchmark::State& state) {
  const auto world = testing::MakeRingWorld(3, 18000);
  const auto made =
      testing::MakeSyntheticMap(world, testing::PosesOnRing(0, 3, 64), {.drift_yaw_rad = 0.001});
  AdjustBundleRequest request;
  request.view = made.map;
  request.fixed = {made.map.keyframes().begin()->first};
  request.threads = static_cast<int>(state.range(0));
  const auto worker = MakeLocalFusionWorker();
  AdjustBundleResult last;
  for (auto _ : state) {
    auto result = worker->AdjustBundle(request, nullptr);
    if (!result.ok()) {
      state.SkipWithError("not adjusted");
      break;
    }
    last = *std::move(result);
  }
  state.counters["points"] = last.points;
  state.counters["iterations"] = last.iterations;
}
BENCHMARK(BM_AdjustBundle)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace corbslam::fusion_worker

BENCHMARK_MAIN();
