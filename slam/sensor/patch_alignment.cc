#include "slam/sensor/patch_alignment.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>

#include "slam/sensor/patch_refinement.h"

namespace corbslam {
namespace {

constexpr int kRadius_px = kPatchRadius_px;
constexpr int kSide_px = kPatchSide_px;
constexpr int kReach_px = 5;
constexpr int kStripWidth_px = kSide_px + 2 * kReach_px;
constexpr int kArea = kSide_px * kSide_px;
constexpr int kShifts = 2 * kReach_px + 1;

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
  const int whole_x = right_x - kReach_px + static_cast<int>(best);
  const std::optional<float> shift_px = RefineAlignment(left, right, left_x, y, whole_x);
  if (!shift_px.has_value()) return std::nullopt;
  return PatchAlignment{static_cast<float>(whole_x) + *shift_px, least};
}

}  // namespace corbslam
