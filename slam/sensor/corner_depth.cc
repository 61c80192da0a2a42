#include "slam/sensor/corner_depth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace corbslam {
namespace {

// As far as a corner's pixel lies from its edge, in pixels of its octave.
constexpr double kReach_px = 1.5;
// A surface's depths in so small a window, sorted, do not differ more from one to the next.
constexpr double kStep = 1.05;
constexpr size_t kMaxSide_px = 16;  // Beyond twice the reach at the last octave.

class DepthImage {
 public:
  DepthImage(const cv::Mat& depth, double units_per_m) : depth_(depth), units_per_m_(units_per_m) {}

  double At(int x, int y) const {
    if (depth_.type() == CV_16UC1) return depth_.at<uint16_t>(y, x) / units_per_m_;
    const double metres = static_cast<double>(depth_.at<float>(y, x));
    return std::isfinite(metres) && metres > 0 ? metres : 0;
  }

 private:
  const cv::Mat& depth_;
  const double units_per_m_;
};

struct Window {
  std::array<double, kMaxSide_px * kMaxSide_px> depths_m;  // The first `size`.
  size_t size = 0;
};

Window Around(const cv::Mat& depth, const DepthImage& image, int x, int y, int reach_px) {
  Window window;
  for (int v = std::max(0, y - reach_px); v <= std::min(depth.rows - 1, y + reach_px); ++v) {
    for (int u = std::max(0, x - reach_px); u <= std::min(depth.cols - 1, x + reach_px); ++u) {
      const double depth_m = image.At(u, v);
      if (depth_m > 0) window.depths_m[window.size++] = depth_m;
    }
  }
  return window;
}

// The nearer side of the nearest step; not found where there is no step.
struct NearSide {
  bool found = false;
  double farthest_m = 0;
  double mean_m = 0;
};

NearSide FindNearSide(Window& window) {
  const auto begin = window.depths_m.begin();
  const auto end = begin + static_cast<std::ptrdiff_t>(window.size);
  const auto [nearest, farthest] = std::minmax_element(begin, end);
  if (begin == end || *farthest <= kStep * *nearest) return {};  // Most of them.
  std::sort(begin, end);
  double sum = 0;
  for (auto it = begin; it != end; ++it) {
    if (it != begin && *it > kStep * *(it - 1)) {
      return {true, *(it - 1), sum / static_cast<double>(it - begin)};
    }
    sum += *it;
  }
  return {};
}

}  // namespace

double CornerDepth(const cv::Mat& depth, const Keypoint& raw, double units_per_m) {
  const DepthImage image(depth, units_per_m);
  const int x = std::clamp(static_cast<int>(std::lround(raw.x_px)), 0, depth.cols - 1);
  const int y = std::clamp(static_cast<int>(std::lround(raw.y_px)), 0, depth.rows - 1);
  const int reach_px = static_cast<int>(std::lround(kReach_px * ScalePyramid::Scale(raw.octave)));
  Window window = Around(depth, image, x, y, reach_px);
  const NearSide near_side = FindNearSide(window);
  const double own_m = image.At(x, y);
  const bool is_near = own_m > 0 && own_m <= near_side.farthest_m;
  return near_side.found && !is_near ? near_side.mean_m : own_m;
}

}  // namespace corbslam
