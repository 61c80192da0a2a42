// disparity_errors --source sim:WORLD?OPTIONS: how wrong a simulated robot's disparities are, by
// what keypoints lie on: a table of px at level 0 against the true depth. The world must stand
// still (no moving_cars); its pictures are as drawn, without a source's gamma or noise.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client_agent/source/source_spec.h"
#include "services/simulated_source/simulated_source.h"
#include "services/simulation/renderer.h"
#include "services/simulation/sequence/simulated_sequence.h"
#include "services/simulation/sequence/simulated_world.h"
#include "slam/sensor/corner_depth.h"
#include "slam/sensor/sensor.h"
#include "slam/util/status_macros.h"
#include "tests/replay/quantile.h"

namespace corbslam::tests {

using client_agent::FramesOf;
using client_agent::ParseSourceSpec;
using client_agent::SourceSpec;
using services::FindSimulation;

namespace {

struct Flags {
  std::string source;
  size_t every = 25;  // Number of frames from one that is measured to the next.
};

enum Surface { kSmooth, kNearAnEdge, kAtAnEdge, kSurfaces };
constexpr std::array<const char*, kSurfaces> kNames = {"smooth", "an edge within 5 px",
                                                       "an edge within 1.5 px"};
constexpr double kPatchReach_px = 5;  // Pixels of the octave that stereo matching looks at.
constexpr double kSlant = 1.15;       // Depths of a slanted street differ by as much there.

struct Measurement {
  double error_px = 0;  // Measured less true disparity.
  double true_px = 0;
  double scale = 1;  // Scale of the octave.
};

struct DepthRange {
  double nearest_m = 0;
  double farthest_m = 0;
};

// Returns nothing where the window leaves the image.
std::optional<DepthRange> RangeAround(const cv::Mat& depth, const Keypoint& keypoint,
                                      double reach_px) {
  const int x = static_cast<int>(std::lround(keypoint.x_px));
  const int y = static_cast<int>(std::lround(keypoint.y_px));
  const int r = static_cast<int>(std::lround(reach_px * ScalePyramid::Scale(keypoint.octave)));
  if (x < r || y < r || x + r >= depth.cols || y + r >= depth.rows) {
    return std::nullopt;
  }
  DepthRange range;
  cv::minMaxLoc(depth(cv::Rect(x - r, y - r, 2 * r + 1, 2 * r + 1)), &range.nearest_m,
                &range.farthest_m);
  return range;
}

Surface SurfaceOf(const DepthRange& patch, const DepthRange& corner) {
  if (patch.farthest_m < kSlant * patch.nearest_m) return kSmooth;
  return corner.farthest_m < kDepthStep * corner.nearest_m ? kNearAnEdge : kAtAnEdge;
}

using Measurements = std::array<std::vector<Measurement>, kSurfaces>;

void Collect(const Camera& camera, const Features& features, const cv::Mat& depth,
             Measurements& measurements) {
  for (const Keypoint& keypoint : features.keypoints) {
    if (!keypoint.HasDepth()) continue;
    const auto patch = RangeAround(depth, keypoint, kPatchReach_px);
    const auto corner = RangeAround(depth, keypoint, kCornerReach_px);
    if (!patch.has_value() || !corner.has_value()) continue;
    const double true_px = DisparityFromDepth(camera, CornerDepth(depth, keypoint, 1));
    measurements[SurfaceOf(*patch, *corner)].push_back(
        {static_cast<double>(keypoint.disparity_px) - true_px, true_px,
         ScalePyramid::Scale(keypoint.octave)});
  }
}

cv::Mat WithFarSky(cv::Mat depth) {
  constexpr float kFar_m = 1000;
  depth.setTo(kFar_m, depth <= 0);
  return depth;
}

absl::StatusOr<Measurements> Measure(const Flags& flags) {
  ASSIGN_OR_RETURN(const SourceSpec source, ParseSourceSpec(flags.source));
  const SimulationSpec* simulation = FindSimulation(source);
  if (simulation == nullptr || simulation->moving_cars > 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("--source ", flags.source, ": must be sim:WORLD without moving_cars"));
  }
  ASSIGN_OR_RETURN(const auto sequence, SimulatedSequence::Make(*simulation));
  ASSIGN_OR_RETURN(const PoseSequence way, MakeWay(sequence->spec()));
  const Renderer renderer(BuildWorld(sequence->spec(), way));
  ASSIGN_OR_RETURN(const auto sensor, MakeSensor(sequence->calibration(), SensorOptions()));
  Measurements measurements;
  const std::vector<size_t> frames = FramesOf(source, sequence->frame_count());
  for (size_t i = 0; i < frames.size(); i += flags.every) {
    ASSIGN_OR_RETURN(const SensorImages images, sequence->Render(frames[i]));
    ASSIGN_OR_RETURN(const Features features, sensor->Process(images));
    Shot shot;
    shot.world_from_camera = sequence->world_from_camera(frames[i]);
    Collect(sensor->camera(), features, WithFarSky(renderer.DrawDepth(sensor->camera(), shot)),
            measurements);
  }
  return measurements;
}

// Returns the share by which least squares over these makes all depths too large, outliers left
// out.
double MisjudgedScale(const std::vector<Measurement>& measurements) {
  double sum = 0;
  double weight = 0;
  for (const Measurement& m : measurements) {
    constexpr double kOutlier = 2.8;  // The 95 % bound of adjustments, in pixels of the octave.
    if (std::abs(m.error_px) > kOutlier * m.scale) continue;
    sum -= m.true_px * m.error_px / (m.scale * m.scale);
    weight += m.true_px * m.true_px / (m.scale * m.scale);
  }
  return weight > 0 ? sum / weight : 0;
}

void Print(const char* name, const std::vector<Measurement>& measurements) {
  if (measurements.empty()) return;
  std::vector<double> errors;
  for (const Measurement& m : measurements) errors.push_back(m.error_px);
  const auto beyond = std::ranges::count_if(errors, [](double e) { return std::abs(e) > 1; });
  absl::PrintF("| %s | %d | %+.3f | %+.3f to %+.3f | %.1f %% | %+.3f %% |\n", name, errors.size(),
               Quantile(errors, 0.5), Quantile(errors, 0.25), Quantile(errors, 0.75),
               100 * static_cast<double>(beyond) / static_cast<double>(errors.size()),
               100 * MisjudgedScale(measurements));
}

absl::Status Run(const Flags& flags) {
  ASSIGN_OR_RETURN(const Measurements measurements, Measure(flags));
  std::printf(
      "| surface | keypoints | error, px: median | quartiles | beyond 1 px | depths too large |\n"
      "| --- | --- | --- | --- | --- | --- |\n");
  std::vector<Measurement> all;
  for (size_t i = 0; i < kSurfaces; ++i) {
    Print(kNames[i], measurements[i]);
    all.insert(all.end(), measurements[i].begin(), measurements[i].end());
  }
  Print("all", all);
  return absl::OkStatus();
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::services::RegisterSimulatedSources();
  corbslam::tests::Flags flags;
  CLI::App app("Errors of disparities against a simulated world", "disparity_errors");
  app.add_option("--source", flags.source, "sim:WORLD?OPTIONS")->required();
  app.add_option("--every", flags.every, "Frames between those measured")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = corbslam::tests::Run(flags);
  if (status.ok()) return 0;
  std::fprintf(stderr, "disparity_errors: %s\n", status.ToString().c_str());
  return 1;
}
