// Measures how fast pictures of a simulated town are drawn: one iteration is one frame of the
// rig's.
#include <benchmark/benchmark.h>

#include <cstddef>

#include "services/simulation/sequence/simulated_sequence.h"

namespace corbslam {
namespace {

void DrawFrames(benchmark::State& state) {
  SimulationSpec spec;
  spec.seed = 7;
  spec.rig = static_cast<CameraRig>(state.range(0));
  spec.threads = static_cast<int>(state.range(1));
  const auto sequence = SimulatedSequence::Make(spec);
  if (!sequence.ok() || !(*sequence)->Render(0).ok()) {  // The first picture builds the world, too.
    state.SkipWithError("no sequence");
    return;
  }
  // The frames lie all along the way.
  constexpr size_t kStep = 37;
  size_t frame = 0;
  for (auto _ : state) {
    frame = (frame + kStep) % (*sequence)->frame_count();
    benchmark::DoNotOptimize((*sequence)->Render(frame));
  }
  state.counters["frames/s"] =
      benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(DrawFrames)
    ->ArgNames({"rig", "threads"})
    ->Args({static_cast<int>(CameraRig::kKitti), 1})
    ->Args({static_cast<int>(CameraRig::kKitti), 2})
    ->Args({static_cast<int>(CameraRig::kEuroc), 2})
    ->Args({static_cast<int>(CameraRig::kRgbd), 2})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace corbslam

BENCHMARK_MAIN();
