// Measures the coding of a keyframe's features, part by part, on one thread.
#include <benchmark/benchmark.h>

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "slam/coding/descriptor_streams.h"
#include "slam/coding/feature_coding.h"
#include "slam/coding/feature_columns.h"
#include "slam/coding/testing/plausible_features.h"

namespace corbslam {
namespace {

constexpr PictureSize kPicture = {1241, 376};

FeatureColumns Plausible(const benchmark::State& state) {
  return ToColumns(
      testing::MakePlausibleFeatures(1, static_cast<size_t>(state.range(0)), kPicture));
}

void EncodesFeatures(benchmark::State& state) {
  const FeatureColumns columns = Plausible(state);
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(EncodeFeatures(columns, kPicture));
  }
}

void DecodesFeatures(benchmark::State& state) {
  const std::string bytes = EncodeFeatures(Plausible(state), kPicture).value();
  for ([[maybe_unused]] auto _ : state) {
    if (!DecodeFeatures(bytes, bytes.size()).ok()) state.SkipWithError("not decoded");
  }
}

void EncodesDescriptors(benchmark::State& state) {
  const FeatureColumns columns = Plausible(state);
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(EncodeDescriptors(columns.descriptors));
  }
}

void DecodesDescriptors(benchmark::State& state) {
  const FeatureColumns columns = Plausible(state);
  const auto streams = EncodeDescriptors(columns.descriptors);
  std::array<std::string_view, kDescriptorStreams> views;
  for (size_t i = 0; i < views.size(); ++i) views[i] = streams[i];
  std::vector<Descriptor> read(columns.size());
  for ([[maybe_unused]] auto _ : state) {
    if (!DecodeDescriptors(views, read)) state.SkipWithError("not decoded");
  }
}

BENCHMARK(EncodesFeatures)->Arg(2000)->Unit(benchmark::kMillisecond);
BENCHMARK(DecodesFeatures)->Arg(2000)->Unit(benchmark::kMillisecond);
BENCHMARK(EncodesDescriptors)->Arg(2000)->Unit(benchmark::kMillisecond);
BENCHMARK(DecodesDescriptors)->Arg(2000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace corbslam
BENCHMARK_MAIN();
