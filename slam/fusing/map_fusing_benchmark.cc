// Measures the fusing of two maps of 35 keyframes, from an accepted overlap to the result.
#include <benchmark/benchmark.h>

#include "slam/fusing/map_fusing.h"
#include "slam/verification/place_verification.h"
#include "slam/verification/testing/synthetic_world.h"

namespace corbslam {
namespace {

void BM_FuseMaps(benchmark::State& state) {
  const auto world = testing::MakeRingWorld(3, static_cast<int>(state.range(0)));
  const auto a = testing::MakeSyntheticMap(world, testing::PosesOnRing(0, 3, 35),
                                           {.local_map = {0xa}, .drift_yaw_rad = 0.001});
  const auto b = testing::MakeSyntheticMap(world, testing::PosesOnRing(79.5, 3, 35),
                                           {.local_map = {0xb}, .drift_scale = 0.005});
  FuseMapsRequest request;
  request.target = a.map;
  request.source = b.map;
  request.overlaps = {VerifyPlace(b.map, {{0xb}, 2}, a.map, {{0xa}, 28}, {})};
  request.new_overlaps = {0};
  size_t merges = 0;
  for (auto _ : state) {
    const auto result = FuseMaps(request, {}, nullptr);
    if (!result.ok() || !result->accepted) {
      state.SkipWithError("not fused");
      break;
    }
    merges = result->merges.size();
  }
  state.counters["points"] = static_cast<double>(a.map.points().size() + b.map.points().size());
  state.counters["merges"] = static_cast<double>(merges);
}
BENCHMARK(BM_FuseMaps)->Arg(6000)->Arg(18000)->Unit(benchmark::kMillisecond);

void BM_VerifyPlace(benchmark::State& state) {
  const auto world = testing::MakeRingWorld(3, static_cast<int>(state.range(0)));
  const auto a =
      testing::MakeSyntheticMap(world, testing::PosesOnRing(0, 3, 12), {.local_map = {0xa}});
  const auto b = testing::MakeSyntheticMap(world, testing::PosesOnRing(13.5, 3, 12),
                                           {.local_map = {0xb}, .seed = 2});
  for (auto _ : state) {
    benchmark::DoNotOptimize(VerifyPlace(b.map, {{0xb}, 2}, a.map, {{0xa}, 6}, {}));
  }
}
BENCHMARK(BM_VerifyPlace)->Arg(6000)->Arg(18000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace corbslam

BENCHMARK_MAIN();
