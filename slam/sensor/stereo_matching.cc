#include "slam/sensor/stereo_matching.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "absl/types/span.h"
#include "slam/sensor/patch_alignment.h"
#include "slam/util/median.h"

namespace corbslam {
namespace {

// Half the height of the band in which a keypoint's counterpart is sought, pixels of its octave.
constexpr double kBand_px = 2.0;
// Points at infinity have measured disparities around 0.
constexpr float kLeastMeasured_px = -0.5F;
constexpr float kLeastDisparity_px = 0.01F;

// What the search reads of a right keypoint.
struct Candidate {
  float x_px = 0;
  uint32_t id = 0;
  Descriptor descriptor;
};

// Lists for each row and octave the right keypoints that may lie there, in order of their index.
class RowIndex {
 public:
  RowIndex(const Features& features, int rows)
      : begin_(static_cast<size_t>(rows * ScalePyramid::kLevels) + 1, 0) {
    ForEach(features, rows, [&](size_t list, uint32_t) { ++begin_[list + 1]; });
    for (size_t list = 0; list + 1 < begin_.size(); ++list) begin_[list + 1] += begin_[list];
    candidates_.resize(begin_.back());
    std::vector<uint32_t> next(begin_.begin(), begin_.end() - 1);
    ForEach(features, rows, [&](size_t list, uint32_t id) {
      candidates_[next[list]++] = {features.keypoints[id].x_px, id, features.descriptors[id]};
    });
  }

  // Returns the candidates of the row whose octave is at most one away.
  absl::Span<const Candidate> Near(int row, int octave) const {
    const int first = row * ScalePyramid::kLevels + std::max(0, octave - 1);
    const int last = row * ScalePyramid::kLevels + std::min(ScalePyramid::kLevels - 1, octave + 1);
    const size_t begin = begin_[static_cast<size_t>(first)];
    return absl::MakeConstSpan(candidates_)
        .subspan(begin, begin_[static_cast<size_t>(last) + 1] - begin);
  }

 private:
  template <typename Visit>
  static void ForEach(const Features& features, int rows, Visit visit) {
    for (uint32_t i = 0; i < features.keypoints.size(); ++i) {
      const Keypoint& keypoint = features.keypoints[i];
      const double band = kBand_px * ScalePyramid::Scale(keypoint.octave);
      const int first = std::max(0, static_cast<int>(std::floor(keypoint.y_px - band)));
      const int last = std::min(rows - 1, static_cast<int>(std::ceil(keypoint.y_px + band)));
      for (int row = first; row <= last; ++row) {
        visit(static_cast<size_t>(row * ScalePyramid::kLevels + keypoint.octave), i);
      }
    }
  }

  std::vector<uint32_t> begin_;
  std::vector<Candidate> candidates_;
};

std::optional<uint32_t> FindMostSimilar(const Keypoint& keypoint, const Descriptor& descriptor,
                                        const RowIndex& rows, int row,
                                        const StereoMatchingOptions& options) {
  int least = options.max_hamming + 1;
  std::optional<uint32_t> best;
  // Right columns that differ by less than a pixel of the octave may stand for infinity.
  const double slack = ScalePyramid::Scale(keypoint.octave);
  for (const Candidate& candidate : rows.Near(row, keypoint.octave)) {
    const float disparity = keypoint.x_px - candidate.x_px;
    if (disparity < -slack || disparity > options.max_disparity_px) continue;
    const int distance = HammingDistance(descriptor, candidate.descriptor);
    if (distance < least) {
      least = distance;
      best = candidate.id;
    }
  }
  return best;
}

struct Measured {
  size_t id = 0;
  float disparity_px = 0;
  float lower_px = 0;  // Of the right one, in rows of level 0.
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
  return Measured{id, static_cast<float>(shift * left_pyramid.ScaleX(octave)),
                  static_cast<float>(aligned->lower_px * left_pyramid.ScaleY(octave)),
                  aligned->difference};
}

int MedianDifference(const std::vector<Measured>& measured) {
  std::vector<int> differences;
  differences.reserve(measured.size());
  for (const Measured& m : measured) differences.push_back(m.difference);
  return Median(std::move(differences));
}

// Measures the disparity of one left keypoint at a time.
class Matcher {
 public:
  Matcher(const Features& right, const ImagePyramid& left_pyramid,
          const ImagePyramid& right_pyramid, const StereoMatchingOptions& options)
      : right_(right),
        left_pyramid_(left_pyramid),
        right_pyramid_(right_pyramid),
        options_(options),
        height_px_(left_pyramid.levels[0].rows),
        rows_(right, height_px_) {}

  std::optional<Measured> Match(const Features& left, size_t id) const {
    const Keypoint& keypoint = left.keypoints[id];
    const int row = std::clamp(static_cast<int>(std::lround(keypoint.y_px)), 0, height_px_ - 1);
    const std::optional<uint32_t> best =
        FindMostSimilar(keypoint, left.descriptors[id], rows_, row, options_);
    if (!best.has_value()) return std::nullopt;
    std::optional<Measured> m =
        Measure(keypoint, id, right_.keypoints[*best], left_pyramid_, right_pyramid_);
    if (m.has_value()) m->disparity_px += static_cast<float>(options_.disparity_offset_px);
    if (!m.has_value() || m->disparity_px < kLeastMeasured_px ||
        m->disparity_px > options_.max_disparity_px) {
      return std::nullopt;
    }
    return m;
  }

 private:
  const Features& right_;
  const ImagePyramid& left_pyramid_;
  const ImagePyramid& right_pyramid_;
  const StereoMatchingOptions& options_;
  const int height_px_;
  const RowIndex rows_;
};

// Results are in the order of the keypoints.
std::vector<Measured> MatchAll(const Matcher& matcher, const Features& left, ThreadPair& threads) {
  constexpr size_t kTask = 100;  // Number of keypoints.
  const size_t count = left.keypoints.size();
  std::vector<std::optional<Measured>> found(count);
  threads.Run((count + kTask - 1) / kTask, [&](size_t task) {
    const size_t end = std::min((task + 1) * kTask, count);
    for (size_t i = task * kTask; i < end; ++i) found[i] = matcher.Match(left, i);
  });
  std::vector<Measured> measured;
  measured.reserve(count);
  for (const std::optional<Measured>& m : found) {
    if (m.has_value()) measured.push_back(*m);
  }
  return measured;
}

}  // namespace

RowEvidence MatchStereo(const Features& right, const ImagePyramid& left_pyramid,
                        const ImagePyramid& right_pyramid, const StereoMatchingOptions& options,
                        ThreadPair& threads, Features& left) {
  for (Keypoint& keypoint : left.keypoints) keypoint.disparity_px = 0;
  if (right.keypoints.empty()) return {};
  const Matcher matcher(right, left_pyramid, right_pyramid, options);
  const std::vector<Measured> measured = MatchAll(matcher, left, threads);
  if (measured.empty()) return {};
  const double limit = options.max_median_ratio * MedianDifference(measured);
  std::vector<float> lower_px;
  for (const Measured& m : measured) {
    if (m.difference > limit) continue;
    left.keypoints[m.id].disparity_px = std::max(m.disparity_px, kLeastDisparity_px);
    lower_px.push_back(m.lower_px);
  }
  if (lower_px.empty()) return {};
  const size_t counterparts = lower_px.size();
  return {Median(std::move(lower_px)), counterparts};
}

}  // namespace corbslam
