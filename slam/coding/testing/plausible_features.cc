#include "slam/coding/testing/plausible_features.h"

#include <algorithm>
#include <array>
#include <random>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "slam/coding/descriptor_streams.h"
#include "slam/coding/feature_columns.h"

namespace corbslam::testing {
namespace {

// Every stream says some descriptors: those of random bits are drawn by the model.
std::vector<Descriptor> DrawDescriptors(std::mt19937& random, size_t count) {
  std::array<std::string, kDescriptorStreams> bytes;
  std::array<std::string_view, kDescriptorStreams> streams;
  for (size_t i = 0; i < bytes.size(); ++i) {
    bytes[i].resize(16 * count + 64);
    for (char& byte : bytes[i]) byte = static_cast<char>(random());
    streams[i] = bytes[i];
  }
  std::vector<Descriptor> descriptors(count);
  // False as a rule: the streams are longer.
  (void)DecodeDescriptors(streams, descriptors);
  return descriptors;
}

}  // namespace

Features MakePlausibleFeatures(uint32_t seed, size_t count, const PictureSize& picture) {
  std::mt19937 random(seed);
  std::vector<std::array<int64_t, 3>> corners(count);
  const auto below = [&random](int64_t limit) { return static_cast<int64_t>(random()) % limit; };
  for (auto& [octave, row, column] : corners) {
    octave = below(ScalePyramid::kLevels);
    row = below(LevelGrid(picture.height_px, static_cast<int>(octave)).side_px());
    column = below(LevelGrid(picture.width_px, static_cast<int>(octave)).side_px());
  }
  std::ranges::sort(corners);
  FeatureColumns columns;
  for (const auto& [octave, row, column] : corners) {
    const auto level = static_cast<int>(octave);
    columns.x_px64.push_back(
        static_cast<int32_t>(LevelGrid(picture.width_px, level).PositionOf(column)));
    columns.y_px64.push_back(
        static_cast<int32_t>(LevelGrid(picture.height_px, level).PositionOf(row)));
    columns.disparity_px128.push_back(
        static_cast<uint32_t>(random() % 3 == 0 ? 0 : 1 + random() % 8000));
    columns.angle_turn14.push_back(static_cast<uint32_t>(random() % kTurnSteps));
    columns.octaves.push_back(static_cast<char>(octave));
  }
  columns.descriptors = DrawDescriptors(random, count);
  return FromColumns(std::move(columns));
}

}  // namespace corbslam::testing
