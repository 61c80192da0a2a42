#include "slam/sensor/stereo_matching.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "slam/sensor/patch_alignment.h"
#include "slam/util/median.h"

namespace corbslam {
namespace {

// Half the height of the band in which a keypoint's counterpart is sought, pixels of its octave.
constexpr double kBand_px = 2.0;
// Points at infinity measure a disparity around 0.
constexpr float kLeastMeasured_px = -0.5F;
constexpr float kLeastDisparity_px = 0.01F;

// For each row, the right keypoints that may lie on it, in order of their index.
class RowIndex {
 public:
  RowIndex(const Features& features, int rows) : begin_(static_cast<size_t>(rows) + 1, 0) {
    ForEach(features, rows, [&](size_t row, uint32_t) { ++begin_[row + 1]; });
    for (size_t row = 0; row + 1 < begin_.size(); ++row) begin_[row + 1] += begin_[row];
    ids_.resize(begin_.back());
    std::vector<size_t> next(begin_.begin(), begin_.end() - 1);
    ForEach(features, rows, [&](size_t row, uint32_t id) { ids_[next[row]++] = id; });
  }

  const uint32_t* begin(int row) const { return &ids_[0] + begin_[static_cast<size_t>(row)]; }
  const uint32_t* end(int row) const { return &ids_[0] + begin_[static_cast<size_t>(row) + 1]; }

 private:
  template <typename Visit>
  static void ForEach(const Features& features, int rows, Visit visit) {
    for (uint32_t i = 0; i < features.keypoints.size(); ++i) {
      const Keypoint& keypoint = features.keypoints[i];
      const double band = kBand_px * ScalePyramid::Scale(keypoint.octave);
      const int first = std::max(0, static_cast<int>(std::floor(keypoint.y_px - band)));
      const int last = std::min(rows - 1, static_cast<int>(std::ceil(keypoint.y_px + band)));
      for (int row = first; row <= last; ++row) visit(static_cast<size_t>(row), i);
    }
  }

  std::vector<size_t> begin_;
  std::vector<uint32_t> ids_;
};

std::optional<uint32_t> FindMostSimilar(const Features& left, size_t id, const Features& right,
                                        const RowIndex& rows, int row,
                                        const StereoMatchingOptions& options) {
  const Keypoint& keypoint = left.keypoints[id];
  int least = options.max_hamming + 1;
  std::optional<uint32_t> best;
  // Right columns that differ by less than a pixel of the octave may stand for infinity.
  const double slack = ScalePyramid::Scale(keypoint.octave);
  for (const uint32_t* it = rows.begin(row); it != rows.end(row); ++it) {
    const Keypoint& other = right.keypoints[*it];
    const float disparity = keypoint.x_px - other.x_px;
    if (disparity < -slack || disparity > options.max_disparity_px) continue;
    if (std::abs(other.octave - keypoint.octave) > 1) continue;
    const int distance = HammingDistance(left.descriptors[id], right.descriptors[*it]);
    if (distance < least) {
      least = distance;
      best = *it;
    }
  }
  return best;
}

struct Measured {
  size_t id = 0;
  float disparity_px = 0;
  int difference = 0;
};

std::optional<Measured> Measure(const Keypoint& left, size_t id, const Keypoint& right,
                                const ImagePyramid& left_pyramid,
                                const ImagePyramid& right_pyramid) {
  const int octave = left.octave;
  const int left_x = static_cast<int>(std::lround(left_pyramid.FromLevel0X(left.x_px, octave)));
  const int y = static_cast<int>(std::lround(left_pyramid.FromLevel0Y(left.y_px, octave)));
  const int right_x = static_cast<int>(std::lround(right_pyramid.FromLevel0X(right.x_px, octave)));
  const auto level = static_cast<size_t>(octave);
  const std::optional<PatchAlignment> aligned =
      AlignPatch(left_pyramid.levels[level], right_pyramid.levels[level], left_x, y, right_x);
  if (!aligned.has_value()) return std::nullopt;
  const double shift = static_cast<double>(left_x) - aligned->right_x_px;
  return Measured{id, static_cast<float>(shift * left_pyramid.ScaleX(octave)), aligned->difference};
}

int MedianDifference(const std::vector<Measured>& measured) {
  std::vector<int> differences;
  differences.reserve(measured.size());
  for (const Measured& m : measured) differences.push_back(m.difference);
  return Median(std::move(differences));
}

}  // namespace

void MatchStereo(const Features& right, const ImagePyramid& left_pyramid,
                 const ImagePyramid& right_pyramid, const StereoMatchingOptions& options,
                 Features& left) {
  for (Keypoint& keypoint : left.keypoints) keypoint.disparity_px = 0;
  if (right.keypoints.empty()) return;
  const int height = left_pyramid.levels[0].rows;
  const RowIndex rows(right, height);
  std::vector<Measured> measured;
  for (size_t i = 0; i < left.keypoints.size(); ++i) {
    const Keypoint& keypoint = left.keypoints[i];
    const int row = std::clamp(static_cast<int>(std::lround(keypoint.y_px)), 0, height - 1);
    const std::optional<uint32_t> best = FindMostSimilar(left, i, right, rows, row, options);
    if (!best.has_value()) continue;
    std::optional<Measured> m =
        Measure(keypoint, i, right.keypoints[*best], left_pyramid, right_pyramid);
    if (m.has_value()) m->disparity_px += static_cast<float>(options.disparity_offset_px);
    if (!m.has_value() || m->disparity_px < kLeastMeasured_px ||
        m->disparity_px > options.max_disparity_px) {
      continue;
    }
    measured.push_back(*m);
  }
  if (measured.empty()) return;
  const double limit = options.max_median_ratio * MedianDifference(measured);
  for (const Measured& m : measured) {
    if (m.difference > limit) continue;
    left.keypoints[m.id].disparity_px = std::max(m.disparity_px, kLeastDisparity_px);
  }
}

}  // namespace corbslam
