#include "slam/sensor/patch_alignment.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>

namespace corbslam {
namespace {

constexpr int kRadius_px = 5;
constexpr int kSide_px = 2 * kRadius_px + 1;
constexpr int kReach_px = 5;
constexpr double kWeightSigma_px = 2;
// One column more for interpolation beyond the last whole shift.
constexpr int kStripWidth_px = kSide_px + 2 * kReach_px + 1;
constexpr int kArea = kSide_px * kSide_px;
constexpr int kShifts = 2 * kReach_px + 1;
constexpr int kRefinements = 4;
constexpr float kEnough_px = 0.005F;

using Patch = std::array<std::array<int16_t, kSide_px>, kSide_px>;
using Strip = std::array<std::array<int16_t, kStripWidth_px>, kSide_px>;

template <typename Window>
Window CopyWindow(const cv::Mat& image, int first_x, int y) {
  Window window;
  for (size_t v = 0; v < window.size(); ++v) {
    const uint8_t* const row = image.ptr<uint8_t>(y - kRadius_px + static_cast<int>(v)) + first_x;
    for (size_t u = 0; u < window[v].size(); ++u) window[v][u] = row[u];
  }
  return window;
}

bool Inside(const cv::Mat& image, int x, int y, int half_width) {
  return x >= half_width && x + half_width < image.cols && y >= kRadius_px &&
         y + kRadius_px < image.rows;
}

int SumOfDifferences(const Patch& patch, const Strip& strip, size_t shift) {
  int sum = 0;
  for (size_t v = 0; v < kSide_px; ++v) {
    for (size_t u = 0; u < kSide_px; ++u) sum += strip[v][u + shift] - patch[v][u];
  }
  return sum;
}

// Of the patches after their means are made equal: pairs of cameras differ in exposure.
int AbsoluteDifference(const Patch& patch, const Strip& strip, size_t shift) {
  const int16_t bias = static_cast<int16_t>(
      std::lround(static_cast<double>(SumOfDifferences(patch, strip, shift)) / kArea));
  int sum = 0;
  for (size_t v = 0; v < kSide_px; ++v) {
    for (size_t u = 0; u < kSide_px; ++u) {
      sum += std::abs(strip[v][u + shift] - patch[v][u] - bias);
    }
  }
  return sum;
}

// What a pixel of the patch counts for: a keypoint's own surface is in the middle, what lies behind
// its edge is around it.
struct PatchWeights {
  PatchWeights() {
    for (int v = 0; v < kSide_px; ++v) {
      for (int u = 0; u < kSide_px; ++u) {
        const double distance2 = std::pow(u - kRadius_px, 2) + std::pow(v - kRadius_px, 2);
        const double weight = std::exp(-distance2 / (2 * kWeightSigma_px * kWeightSigma_px));
        of[static_cast<size_t>(v)][static_cast<size_t>(u)] = static_cast<float>(weight);
        sum += of[static_cast<size_t>(v)][static_cast<size_t>(u)];
      }
    }
  }

  std::array<std::array<float, kSide_px>, kSide_px> of;
  float sum = 0;
};

const PatchWeights& Weights() {
  static const PatchWeights weights;
  return weights;
}

// One Gauss-Newton step of the column of weighted least squares (Lucas and Kanade, 1981), with the
// shift and an offset of grey values as unknowns; `column` counts from the strip's first.
float AlignmentStep(const Patch& patch, const Strip& strip, float column) {
  const PatchWeights& weights = Weights();
  const auto whole = static_cast<size_t>(column);
  const float fraction = column - static_cast<float>(whole);
  float sum_g = 0, sum_gg = 0, sum_r = 0, sum_gr = 0;
  for (size_t v = 0; v < kSide_px; ++v) {
    const int16_t* const row = &strip[v][whole];
    for (size_t u = 0; u < kSide_px; ++u) {
      const float here = static_cast<float>(row[u]);
      const float slope = static_cast<float>(row[u + 1]) - here;
      const float residual = static_cast<float>(patch[v][u]) - (here + fraction * slope);
      const float weight = weights.of[v][u];
      sum_g += weight * slope;
      sum_gg += weight * slope * slope;
      sum_r += weight * residual;
      sum_gr += weight * slope * residual;
    }
  }
  const float information = sum_gg - sum_g * sum_g / weights.sum;
  if (!(information > 1.0F)) return std::numeric_limits<float>::infinity();
  return (sum_gr - sum_g * sum_r / weights.sum) / information;
}

// Column of the strip, from the best whole one; nothing where it strays from that.
std::optional<float> RefineColumn(const Patch& patch, const Strip& strip, size_t best) {
  const float start = static_cast<float>(best);
  float column = start;
  for (int i = 0; i < kRefinements; ++i) {
    const float step = AlignmentStep(patch, strip, column);
    column += step;
    if (!(std::abs(column - start) <= 1.0F)) return std::nullopt;
    if (std::abs(step) < kEnough_px) break;
  }
  return column;
}

}  // namespace

std::optional<PatchAlignment> AlignPatch(const cv::Mat& left, const cv::Mat& right, int left_x,
                                         int y, int right_x) {
  if (!Inside(left, left_x, y, kRadius_px) || !Inside(right, right_x, y, kRadius_px + kReach_px)) {
    return std::nullopt;
  }
  const Patch patch = CopyWindow<Patch>(left, left_x - kRadius_px, y);
  const Strip strip = CopyWindow<Strip>(right, right_x - kRadius_px - kReach_px, y);
  size_t best = 0;
  int least = std::numeric_limits<int>::max();
  for (size_t shift = 0; shift < kShifts; ++shift) {
    const int difference = AbsoluteDifference(patch, strip, shift);
    if (difference < least) {
      least = difference;
      best = shift;
    }
  }
  if (best == 0 || best == kShifts - 1) return std::nullopt;
  const std::optional<float> column = RefineColumn(patch, strip, best);
  if (!column.has_value()) return std::nullopt;
  return PatchAlignment{static_cast<float>(right_x - kReach_px) + *column, least};
}

}  // namespace corbslam
