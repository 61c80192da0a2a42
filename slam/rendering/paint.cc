#include "slam/rendering/paint.h"

#include <algorithm>
#include <cmath>

namespace corbslam {
namespace {

// The ramp's colours at equal distances. They grow lighter and go from blue to yellow, which those
// who don't tell red from green see, too: a quarter of the ramp apart, colours differ by 16
// (CIELAB) for them.
constexpr std::array<Paint, 5> kRamp = {{{nullptr, 35, 90, 215},
                                         {nullptr, 105, 95, 190},
                                         {nullptr, 165, 100, 140},
                                         {nullptr, 205, 115, 80},
                                         {nullptr, 225, 140, 0}}};

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
