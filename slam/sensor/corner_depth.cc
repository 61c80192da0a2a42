#include "slam/sensor/corner_depth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace corbslam {
namespace {

constexpr size_t kMaxSide_px = 16;  // More than twice the reach at the last octave.

// The largest value of 16 bits isn't measured: it is what many cameras write where they saw none.
constexpr uint16_t kSaturated = 65535;

double DepthAt(const cv::Mat& depth, int x, int y, double units_per_m) {
  if (depth.type() == CV_16UC1) {
    const uint16_t units = depth.at<uint16_t>(y, x);
    return units == kSaturated ? 0 : units / units_per_m;
  }
  const double metres = static_cast<double>(depth.at<float>(y, x));
  return std::isfinite(metres) && metres > 0 ? metres : 0;
}

struct Window {
  std::array<double, kMaxSide_px * kMaxSide_px> depths_m;  // The first `size` are set.
  size_t size = 0;
};

Window Around(const cv::Mat& depth, int x, int y, int reach_px, double units_per_m) {
  Window window;
  for (int v = std::max(0, y - reach_px); v <= std::min(depth.rows - 1, y + reach_px); ++v) {
    for (int u = std::max(0, x - reach_px); u <= std::min(depth.cols - 1, x + reach_px); ++u) {
      const double depth_m = DepthAt(depth, u, v, units_per_m);
      if (depth_m > 0) window.depths_m[window.size++] = depth_m;
    }
  }
  return window;
}

struct NearSide {
  double farthest_m = 0;
  double mean_m = 0;
};

// Returns the near side of the nearest step; sorts the window.
std::optional<NearSide> FindNearSide(Window& window) {
  const auto begin = window.depths_m.begin();
  const auto end = begin + static_cast<std::ptrdiff_t>(window.size);
  if (begin == end) return std::nullopt;
  const auto [nearest, farthest] = std::minmax_element(begin, end);
  if (*farthest <= kDepthStep * *nearest) return std::nullopt;  // Most corners end here.
  std::sort(begin, end);
  double sum = *begin;
  for (auto it = begin + 1; it != end; ++it) {
    if (*it > kDepthStep * *(it - 1)) {
      return NearSide{*(it - 1), sum / static_cast<double>(it - begin)};
    }
    sum += *it;
  }
  return std::nullopt;
}

}  // namespace

double CornerDepth(const cv::Mat& depth, const Keypoint& raw, double units_per_m) {
  const int x = std::clamp(static_cast<int>(std::lround(raw.x_px)), 0, depth.cols - 1);
  const int y = std::clamp(static_cast<int>(std::lround(raw.y_px)), 0, depth.rows - 1);
  const double own_m = DepthAt(depth, x, y, units_per_m);
  const double reach_px = kCornerReach_px * ScalePyramid::Scale(raw.octave);
  Window window = Around(depth, x, y, static_cast<int>(std::lround(reach_px)), units_per_m);
  const std::optional<NearSide> near_side = FindNearSide(window);
  if (!near_side.has_value() || (own_m > 0 && own_m <= near_side->farthest_m)) return own_m;
  return near_side->mean_m;
}

}  // namespace corbslam
