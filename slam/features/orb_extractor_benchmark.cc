// Measures the extraction of ORB features beside OpenCV's own, on recorded pictures and one thread.
// CORBSLAM_DATA_DIR must name the folder of recorded sequences.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <iostream>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "slam/features/orb_extractor.h"

namespace corbslam {
namespace {

const std::vector<cv::Mat>& Pictures() {
  static const auto* const pictures = [] {
    auto* const read = new std::vector<cv::Mat>;
    const char* const folder = std::getenv("CORBSLAM_DATA_DIR");
    for (int i = 0; folder != nullptr && i <= 200; i += 10) {
      const std::string file = absl::StrFormat("%s/kitti_00_first201/image_0/%06d.png", folder, i);
      cv::Mat picture = cv::imread(file, cv::IMREAD_GRAYSCALE);
      if (!picture.empty()) read->push_back(picture);
    }
    return read;
  }();
  return *pictures;
}

void ExtractOurs(benchmark::State& state) {
  if (Pictures().empty()) return state.SkipWithError("no pictures in CORBSLAM_DATA_DIR");
  cv::setNumThreads(1);
  OrbExtractor extractor(OrbOptions{.features = static_cast<int>(state.range(0))});
  Features features;
  ImagePyramid pyramid;
  size_t next = 0;
  size_t found = 0;
  for ([[maybe_unused]] auto _ : state) {
    const cv::Mat& picture = Pictures()[next++ % Pictures().size()];
    if (!extractor.Extract(picture, features, pyramid).ok()) state.SkipWithError("Extract failed");
    found += features.keypoints.size();
  }
  state.counters["features"] =
      benchmark::Counter(static_cast<double>(found), benchmark::Counter::kAvgIterations);
}

void ExtractOpenCv(benchmark::State& state) {
  if (Pictures().empty()) return state.SkipWithError("no pictures in CORBSLAM_DATA_DIR");
  cv::setNumThreads(1);
  const auto orb = cv::ORB::create(static_cast<int>(state.range(0)), 1.2F, 8);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  size_t next = 0;
  size_t found = 0;
  for ([[maybe_unused]] auto _ : state) {
    const cv::Mat& picture = Pictures()[next++ % Pictures().size()];
    orb->detectAndCompute(picture, cv::noArray(), keypoints, descriptors);
    found += keypoints.size();
  }
  state.counters["features"] =
      benchmark::Counter(static_cast<double>(found), benchmark::Counter::kAvgIterations);
}

BENCHMARK(ExtractOurs)->Arg(2000)->Arg(1000)->Unit(benchmark::kMillisecond);
BENCHMARK(ExtractOpenCv)->Arg(2000)->Arg(1000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace corbslam

BENCHMARK_MAIN();
