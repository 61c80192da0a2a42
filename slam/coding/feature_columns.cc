#include "slam/coding/feature_columns.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace corbslam {
namespace {

constexpr double kStepsPerRadian = kTurnSteps / (2 * std::numbers::pi);

int32_t RoundPosition(float position_px) {
  return static_cast<int32_t>(std::lround(position_px * kPositionSteps_px));
}

uint32_t RoundDisparity(float disparity_px) {
  if (!(disparity_px > 0)) return 0;
  const double steps = std::round(disparity_px * kDisparitySteps_px);
  // A known disparity stays known.
  return static_cast<uint32_t>(std::clamp(steps, 1.0, double{kMaxDisparity_px128}));
}

uint32_t RoundAngle(float angle_rad) {
  const long steps = std::lround(angle_rad * kStepsPerRadian);
  return static_cast<uint32_t>(steps) & (kTurnSteps - 1);
}

float AngleOf(uint32_t steps) {
  // The result is within (-pi, pi].
  const auto turn = static_cast<int>(kTurnSteps);
  const int centred =
      steps > kTurnSteps / 2 ? static_cast<int>(steps) - turn : static_cast<int>(steps);
  return static_cast<float>(centred / kStepsPerRadian);
}

}  // namespace

FeatureColumns ToColumns(const Features& features) {
  FeatureColumns columns;
  const size_t count = features.keypoints.size();
  columns.x_px64.reserve(count);
  columns.y_px64.reserve(count);
  columns.angle_turn14.reserve(count);
  columns.octaves.reserve(count);
  const bool any_depth =
      std::ranges::any_of(features.keypoints, [](const Keypoint& k) { return k.HasDepth(); });
  if (any_depth) columns.disparity_px128.reserve(count);
  for (const Keypoint& keypoint : features.keypoints) {
    columns.x_px64.push_back(RoundPosition(keypoint.x_px));
    columns.y_px64.push_back(RoundPosition(keypoint.y_px));
    if (any_depth) columns.disparity_px128.push_back(RoundDisparity(keypoint.disparity_px));
    columns.angle_turn14.push_back(RoundAngle(keypoint.angle_rad));
    columns.octaves.push_back(static_cast<char>(keypoint.octave));
  }
  columns.descriptors = features.descriptors;
  return columns;
}

Features FromColumns(FeatureColumns columns) {
  Features features;
  features.keypoints.resize(columns.size());
  for (size_t i = 0; i < columns.size(); ++i) {
    Keypoint& keypoint = features.keypoints[i];
    keypoint.x_px = static_cast<float>(columns.x_px64[i] / kPositionSteps_px);
    keypoint.y_px = static_cast<float>(columns.y_px64[i] / kPositionSteps_px);
    if (!columns.disparity_px128.empty()) {
      keypoint.disparity_px = static_cast<float>(columns.disparity_px128[i] / kDisparitySteps_px);
    }
    keypoint.angle_rad = AngleOf(columns.angle_turn14[i]);
    keypoint.octave = static_cast<uint8_t>(columns.octaves[i]);
  }
  features.descriptors = std::move(columns.descriptors);
  return features;
}

}  // namespace corbslam
