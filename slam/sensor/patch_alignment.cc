#include "slam/sensor/patch_alignment.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "slam/features/pixel_kernels.h"
#include "slam/sensor/patch_refinement.h"

namespace corbslam {
namespace {

constexpr int kRadius_px = kPatchRadius_px;
constexpr int kReach_px = (kStripShifts - 1) / 2;
static_assert(kGreySide_px == kPatchSide_px);

// What lies beyond the picture is 0; a window's first row and column are inside it.
template <typename Window>
Window CopyWindow(const cv::Mat& image, int first_x, int first_y) {
  Window window = {};
  const size_t columns = std::min(window[0].size(), static_cast<size_t>(image.cols - first_x));
  for (size_t v = 0; v < window.size(); ++v) {
    const uint8_t* const row = image.ptr<uint8_t>(first_y + static_cast<int>(v)) + first_x;
    if (columns == window[v].size()) {
      std::copy_n(row, window[v].size(), window[v].begin());
    } else {
      std::copy_n(row, columns, window[v].begin());
    }
  }
  return window;
}

bool Inside(const cv::Mat& image, int x, int y, int half_width) {
  return x >= half_width && x + half_width < image.cols && y >= kRadius_px &&
         y + kRadius_px < image.rows;
}

}  // namespace

std::optional<PatchAlignment> AlignPatch(const cv::Mat& left, const cv::Mat& right, int left_x,
                                         int y, int right_x) {
  if (!Inside(left, left_x, y, kRadius_px) || !Inside(right, right_x, y, kRadius_px + kReach_px)) {
    return std::nullopt;
  }
  const auto patch = CopyWindow<GreyPatch>(left, left_x - kRadius_px, y - kRadius_px);
  const auto strip = CopyWindow<GreyStrip>(right, right_x - kRadius_px - kReach_px, y - kRadius_px);
  std::array<int, kStripShifts> differences;
  BestPixelKernels().strip_differences(patch, strip, differences);
  const auto least = std::min_element(differences.begin(), differences.end());
  const auto best = least - differences.begin();
  if (best == 0 || best == kStripShifts - 1) return std::nullopt;
  const int whole_x = right_x - kReach_px + static_cast<int>(best);
  const std::optional<PatchShift> shift = RefineAlignment(left, right, left_x, y, whole_x);
  if (!shift.has_value()) return std::nullopt;
  return PatchAlignment{static_cast<float>(whole_x) + shift->x_px, shift->y_px, *least};
}

}  // namespace corbslam
