// Axes of plots: round ticks, and where a value lies.
#ifndef CORBSLAM_SLAM_RENDERING_PLOT_AXES_H_
#define CORBSLAM_SLAM_RENDERING_PLOT_AXES_H_

#include <string>
#include <vector>

#include "slam/rendering/surface.h"

namespace corbslam {

struct Range {
  double low = 0;
  double high = 1;
};

// Returns the range of the finite values; with `with_zero` of them and 0. Never empty, and not
// wider than numbers are: without finite values it is 0 to 1.
Range RangeOf(const std::vector<double>& values, bool with_zero);

struct Ticks {
  std::vector<double> values;  // Ascending, within the range; at least one.
  double step = 1;             // 1, 2 or 5 times a power of ten.
};

// Returns about `most` (at least 2) ticks, not more.
Ticks RoundTicks(const Range& range, size_t most);

// Returns a tick's text, with as many decimals as its step needs.
std::string FormatTick(double value, double step);

// One axis: `range` lies between two coordinates of the picture.
struct Axis {
  Range range;
  double low_px = 0;
  double high_px = 1;
  double Place(double value) const {
    return low_px + (value - range.low) / (range.high - range.low) * (high_px - low_px);
  }
};

inline constexpr double kPlotLetter_px = 9.5;

// Draws grid lines with ticks at x (below) and y (on the left), and the labels: that of x below,
// that of y above its axis.
void DrawAxes(const Axis& x, const std::string& x_label, const Axis& y, const std::string& y_label,
              Surface& surface);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_RENDERING_PLOT_AXES_H_
