#include "slam/map/feature_grid.h"

#include <algorithm>
#include <cmath>

namespace corbslam {
namespace {

constexpr double kCellSide_px = 16;

}  // namespace

int FeatureGrid::Column(double x_px) const {
  return std::clamp(static_cast<int>(std::floor(x_px / kCellSide_px)), 0, columns_ - 1);
}

int FeatureGrid::Row(double y_px) const {
  return std::clamp(static_cast<int>(std::floor(y_px / kCellSide_px)), 0, rows_ - 1);
}

FeatureGrid::FeatureGrid(const Camera& camera, const std::vector<Keypoint>& keypoints)
    : columns_(std::max(1, static_cast<int>(std::ceil(camera.width_px / kCellSide_px)))),
      rows_(std::max(1, static_cast<int>(std::ceil(camera.height_px / kCellSide_px)))),
      begin_(static_cast<size_t>(columns_ * rows_) + 1, 0),
      indices_(keypoints.size()) {
  std::vector<size_t> cells(keypoints.size());
  for (size_t i = 0; i < keypoints.size(); ++i) {
    cells[i] = static_cast<size_t>(Row(keypoints[i].y_px) * columns_ + Column(keypoints[i].x_px));
    ++begin_[cells[i] + 1];
  }
  for (size_t c = 1; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
  std::vector<uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (size_t i = 0; i < keypoints.size(); ++i) {
    indices_[next[cells[i]]++] = static_cast<uint32_t>(i);
  }
}

void FeatureGrid::FindNear(const std::vector<Keypoint>& keypoints, double x_px, double y_px,
                           double radius_px, int min_octave, int max_octave,
                           std::vector<uint32_t>& found) const {
  if (columns_ == 0) return;
  const int last_row = Row(y_px + radius_px);
  const int first_column = Column(x_px - radius_px);
  const int last_column = Column(x_px + radius_px);
  for (int row = Row(y_px - radius_px); row <= last_row; ++row) {
    // The cells of one row stand side by side.
    const uint32_t end = begin_[static_cast<size_t>(row * columns_ + last_column) + 1];
    for (uint32_t i = begin_[static_cast<size_t>(row * columns_ + first_column)]; i < end; ++i) {
      const Keypoint& keypoint = keypoints[indices_[i]];
      if (keypoint.octave < min_octave || keypoint.octave > max_octave) continue;
      if (std::abs(keypoint.x_px - x_px) > radius_px) continue;
      if (std::abs(keypoint.y_px - y_px) > radius_px) continue;
      found.push_back(indices_[i]);
    }
  }
}

}  // namespace corbslam
