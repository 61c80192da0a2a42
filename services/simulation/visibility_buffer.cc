#include "services/simulation/visibility_buffer.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "services/simulation/lanes.h"

namespace corbslam {
namespace {

template <typename T>
Eight<T> AllEight(T value) {
  Eight<T> all;
  all.lanes.fill(value);
  return all;
}

}  // namespace

VisibilityBuffer::VisibilityBuffer(int width_px, int height_px, std::vector<SampleOffset> samples)
    : width_px_(width_px),
      height_px_(height_px),
      blocks_((width_px + kNumbers - 1) / kNumbers),
      samples_(std::move(samples)),
      nearness_(RowStart(samples_.size(), 0), AllEight(kLeastNearness)),
      faces_(RowStart(samples_.size(), 0), AllEight(kNoFace)),
      farthest_(TileOf(0, height_px + kTileRows), kLeastNearness),
      changed_(farthest_.size(), 0) {
  const int used = width_px - kNumbers * (blocks_ - 1);
  for (size_t sample = 0; sample < samples_.size(); ++sample) {
    for (int y = 0; y < height_px; ++y) {
      auto& last = NearnessRow(sample, y)[blocks_ - 1].lanes;
      std::fill(last.begin() + used, last.end(), kMostNearness);
    }
  }
}

float VisibilityBuffer::MeasureFarthest(int block, int tile_row) {
  const int top = tile_row * kTileRows;
  const int bottom = std::min(top + kTileRows, height_px_);
  Floats least = All(std::numeric_limits<float>::max());
  for (size_t sample = 0; sample < samples_.size(); ++sample) {
    for (int y = top; y < bottom; ++y) least = Least(least, Load(NearnessRow(sample, y)[block]));
  }
  float farthest = least[0];
  for (int lane = 1; lane < kNumbers; ++lane) farthest = std::min<float>(farthest, least[lane]);
  return farthest;
}

bool VisibilityBuffer::IsHidden(const PixelRect& rect, float nearness) {
  for (int row = rect.top / kTileRows; row <= rect.bottom / kTileRows; ++row) {
    for (int block = rect.left / kNumbers; block <= rect.right / kNumbers; ++block) {
      const size_t tile = TileOf(block, row * kTileRows);
      if (changed_[tile] != 0) {
        farthest_[tile] = MeasureFarthest(block, row);
        changed_[tile] = 0;
      }
      if (farthest_[tile] < nearness) return false;
    }
  }
  return true;
}

}  // namespace corbslam
