#include "slam/rendering/paint.h"

#include <algorithm>
#include <cmath>

namespace corbslam {
namespace {

// The ramp's colours at equal distances.
constexpr std::array<Paint, 5> kRamp = {{{nullptr, 45, 105, 200},
                                         {nullptr, 0, 155, 165},
                                         {nullptr, 95, 165, 60},
                                         {nullptr, 230, 145, 0},
                                         {nullptr, 215, 45, 35}}};

uint8_t Mix(uint8_t from, uint8_t to, double share) {
  return static_cast<uint8_t>(std::lround(from + share * (to - from)));
}

}  // namespace

Paint RampPaint(double share) {
  if (!std::isfinite(share)) return {nullptr, 140, 140, 140};
  const double at = std::clamp(share, 0.0, 1.0) * (kRamp.size() - 1);
  const size_t index = std::min(static_cast<size_t>(at), kRamp.size() - 2);
  const Paint& low = kRamp[index];
  const Paint& high = kRamp[index + 1];
  const double rest = at - static_cast<double>(index);
  return {nullptr, Mix(low.red, high.red, rest), Mix(low.green, high.green, rest),
          Mix(low.blue, high.blue, rest)};
}

}  // namespace corbslam
