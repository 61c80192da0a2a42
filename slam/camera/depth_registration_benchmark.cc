// Measures how long it takes to register a depth picture of 640x480 to one of the same size, by the
// colour camera's lens.
#include <benchmark/benchmark.h>

#include <opencv2/core.hpp>

#include "slam/camera/depth_registration.h"

namespace corbslam {
namespace {

void RegisterDepth(benchmark::State& state, const LensModel& lens) {
  DepthGeometry geometry;
  geometry.depth = {580, 580, 314, 252, RadialTangential{.k1 = -0.1}};
  geometry.colour = {525, 525, 320, 240, lens};
  geometry.depth_px = geometry.colour_px = {640, 480};
  geometry.colour_from_depth.translation = {-0.025, 0, 0};
  const auto registration = DepthRegistration::Make(geometry);
  if (!registration.ok()) return state.SkipWithError("the geometry is impossible");
  // Steps of 100 pixels, 1 to 3 metres away.
  cv::Mat depth(480, 640, CV_16UC1);
  for (int y = 0; y < depth.rows; ++y) {
    for (int x = 0; x < depth.cols; ++x) {
      depth.at<uint16_t>(y, x) = static_cast<uint16_t>(1000 + 500 * ((x / 100 + y / 100) % 5) + y);
    }
  }
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(registration->Register(depth, 1000));
  }
}

BENCHMARK_CAPTURE(RegisterDepth, pinhole, RadialTangential{})->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(RegisterDepth, radial_tangential,
                  RadialTangential{.k1 = 0.26, .k2 = -0.95, .p1 = -0.005, .p2 = 0.003, .k3 = 1.16})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(RegisterDepth, equidistant, Equidistant{.k1 = 0.02})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace corbslam

BENCHMARK_MAIN();
