// Measures the time of the pose of one frame: our own solver beside Ceres' TinySolver.
#include <benchmark/benchmark.h>

#include <vector>

#include "slam/optimisation/pose_optimisation.h"
#include "slam/optimisation/testing/synthetic_scene.h"
#include "slam/optimisation/testing/tiny_pose_solver.h"

namespace corbslam {
namespace {

using Solver = PoseEstimate (*)(const Camera&, const Rigid3d&, absl::Span<const PoseObservation>);

// The argument is the largest number of observations.
void OptimisePoseBy(benchmark::State& state, Solver solver) {
  testing::SyntheticSceneOptions options;
  options.keyframes = 2;
  options.points = 2600;
  options.share_with_depth = 0.8;
  options.pixel_noise_px = 0.7;
  options.share_of_outliers = 0.1;
  options.pose_noise_m = 0.05;
  options.pose_noise_rad = 0.01;
  const auto scene = testing::MakeSyntheticScene(options);
  const Keyframe& keyframe = scene.map.keyframes().rbegin()->second;
  std::vector<PoseObservation> observations;
  const auto most = static_cast<size_t>(state.range(0));
  for (size_t i = 0; i < keyframe.points.size() && i < most; ++i) {
    const Keypoint& keypoint = keyframe.keypoints()[i];
    observations.push_back({scene.true_position_in_map.at(keyframe.points[i]), keypoint.Pixel(),
                            keypoint.disparity_px, ScalePyramid::Variance_px2(keypoint.octave)});
  }
  for (auto _ : state) {
    const PoseEstimate estimate = solver(scene.camera, keyframe.camera_from_map, observations);
    state.counters["inliers"] = estimate.inliers;
  }
  state.counters["observations"] = static_cast<double>(observations.size());
}
BENCHMARK_CAPTURE(OptimisePoseBy, own, &OptimisePose)
    ->Arg(200)
    ->Arg(1000)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(OptimisePoseBy, tiny_solver, &testing::OptimisePoseTiny)
    ->Arg(200)
    ->Arg(1000)
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace corbslam

BENCHMARK_MAIN();
