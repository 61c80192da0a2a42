#include "slam/matching/orientation_histogram.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace corbslam {
namespace {

constexpr size_t kKeptBins = 3;

}  // namespace

size_t OrientationHistogram::Bin(float angle_a_rad, float angle_b_rad) {
  const float turn = (angle_a_rad - angle_b_rad) / (2 * std::numbers::pi_v<float>);
  const int bin = static_cast<int>((turn - std::floor(turn)) * kBins);
  return static_cast<size_t>(std::clamp(bin, 0, kBins - 1));
}

void OrientationHistogram::Select() {
  std::array<size_t, kBins> order;
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [this](size_t a, size_t b) { return counts_[a] > counts_[b]; });
  kept_.fill(false);
  for (size_t rank = 0; rank < kKeptBins; ++rank) {
    kept_[order[rank]] = 10 * counts_[order[rank]] >= counts_[order[0]];
  }
}

}  // namespace corbslam
