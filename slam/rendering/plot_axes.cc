#include "slam/rendering/plot_axes.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"

namespace corbslam {
namespace {

// Larger values are no lengths or times of ours, and their differences overflow.
constexpr double kLargest = 1e15;

}  // namespace

Range RangeOf(const std::vector<double>& values, bool with_zero) {
  bool is_first = !with_zero;
  Range range{0, 0};
  for (const double value : values) {
    if (!(std::abs(value) <= kLargest)) continue;
    range.low = is_first ? value : std::min(range.low, value);
    range.high = is_first ? value : std::max(range.high, value);
    is_first = false;
  }
  const double least = std::max(1e-9, 1e-9 * std::max(std::abs(range.low), std::abs(range.high)));
  if (range.high - range.low >= least) return range;
  if (range.low == 0) return {0, 1};
  const double margin = 0.5 * std::abs(range.low);
  return with_zero ? Range{std::min(0.0, 2 * range.low), std::max(0.0, 2 * range.high)}
                   : Range{range.low - margin, range.high + margin};
}

Ticks RoundTicks(const Range& range, size_t most) {
  const double least_step =
      (range.high - range.low) / static_cast<double>(std::max<size_t>(most, 2) - 1);
  const double power = std::pow(10.0, std::floor(std::log10(least_step)));
  Ticks ticks;
  ticks.step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= least_step * (1 - 1e-9)) ticks.step = factor * power;
  }
  const double slack = 1e-9 * ticks.step;
  for (double n = std::ceil((range.low - slack) / ticks.step);
       n * ticks.step <= range.high + slack && ticks.values.size() < most; ++n) {
    ticks.values.push_back(n * ticks.step + 0.0);  // Not -0.
  }
  if (ticks.values.empty()) ticks.values.push_back(range.low);
  return ticks;
}

std::string FormatTick(double value, double step) {
  if (std::abs(value) >= 1e6 || step < 1e-6) return absl::StrFormat("%.4g", value);
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step * (1 + 1e-9)))));
  return absl::StrFormat("%.*f", decimals, value);
}

void DrawAxes(const Axis& x, const std::string& x_label, const Axis& y, const std::string& y_label,
              Surface& surface) {
  const Ticks y_ticks = RoundTicks(y.range, 6);
  for (const double value : y_ticks.values) {
    const double at_px = y.Place(value);
    surface.Line({x.low_px, at_px}, {x.high_px, at_px}, kGrid, 1);
    surface.Text(FormatTick(value, y_ticks.step), {x.low_px - 6, at_px + kPlotLetter_px / 2},
                 kPlotLetter_px, kMuted, Anchor::kEnd);
  }
  const Ticks x_ticks = RoundTicks(x.range, 7);
  for (const double value : x_ticks.values) {
    const double at_px = x.Place(value);
    surface.Line({at_px, y.low_px}, {at_px, y.low_px + 4}, kMuted, 1);
    surface.Text(FormatTick(value, x_ticks.step), {at_px, y.low_px + 8 + kPlotLetter_px},
                 kPlotLetter_px, kMuted, Anchor::kMiddle);
  }
  surface.Line({x.low_px, y.low_px}, {x.high_px, y.low_px}, kMuted, 1);
  surface.Text(x_label, {x.high_px, y.low_px + 16 + 2.2 * kPlotLetter_px}, kPlotLetter_px, kInk,
               Anchor::kEnd);
  surface.Text(y_label, {4, y.high_px - 10}, kPlotLetter_px, kInk);
}

}  // namespace corbslam
