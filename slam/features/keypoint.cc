#include "slam/features/keypoint.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace corbslam {
namespace {

using LevelScales = std::array<double, ScalePyramid::kLevels>;

LevelScales ComputeScales() {
  LevelScales scales;
  scales[0] = 1.0;
  for (size_t i = 1; i < scales.size(); ++i) scales[i] = scales[i - 1] * ScalePyramid::kFactor;
  return scales;
}

const LevelScales kScales = ComputeScales();

}  // namespace

double ScalePyramid::Scale(int octave) { return kScales[static_cast<size_t>(octave)]; }

double ScalePyramid::Variance_px2(int octave) {
  const double scale = Scale(octave);
  return scale * scale;
}

int ScalePyramid::PredictOctave(double max_distance, double distance) {
  static const double kLogFactor = std::log(kFactor);
  const double level = std::ceil(std::log(max_distance / distance) / kLogFactor);
  return static_cast<int>(std::clamp(level, 0.0, static_cast<double>(kLevels - 1)));
}

}  // namespace corbslam
