#include <algorithm>
#include <cmath>
#include <limits>

#include "slam/rendering/map_cell.h"
#include "slam/rendering/plot_axes.h"
#include "slam/rendering/plot_parts.h"
#include "slam/rendering/svg_plots.h"

namespace corbslam {
namespace {

constexpr double kTop_px = 44;  // Height of the colour bar above.
constexpr double kMostHeight_px = 480;
constexpr size_t kColours = 24;
constexpr size_t kMostPoints = 4000;
constexpr size_t kMostTicks = 5;

// Returns the bounds of what is finite; of nothing, an empty list of points gives none.
bool FindBounds(const PathPlot& plot, Bounds& bounds) {
  std::vector<Eigen::Vector2d> all;
  const auto add = [&](const std::vector<Eigen::Vector2d>& points) {
    for (const Eigen::Vector2d& x : points) {
      if (x.allFinite() && x.cwiseAbs().maxCoeff() < 1e12) all.push_back(x);
    }
  };
  for (const PathPlot::Path& path : plot.paths) add(path.points);
  for (const std::vector<Eigen::Vector2d>& path : plot.truth) add(path);
  if (all.empty()) return false;
  bounds = ChooseBounds(all, {});
  return true;
}

// Returns the colour bar's end: the largest value or a little more, so that a tick stands there.
double EndOfScale(const PathPlot& plot) {
  double largest = 0;
  for (const PathPlot::Path& path : plot.paths) {
    for (const double value : path.values) {
      if (std::isfinite(value)) largest = std::max(largest, value);
    }
  }
  if (largest <= 0) return 1;
  const double step = RoundTicks({0, largest}, kMostTicks).step;
  return step * std::ceil(largest / step - 1e-9);
}

// Returns the number of the colour that stands for the value; kColours for what is no number.
size_t ColourOf(double value, double largest) {
  if (!std::isfinite(value)) return kColours;
  const double share = std::clamp(value / largest, 0.0, 1.0);
  return std::min(static_cast<size_t>(share * kColours), kColours - 1);
}

Paint PaintOf(size_t colour) {
  return RampPaint(colour < kColours ? (static_cast<double>(colour) + 0.5) / kColours
                                     : std::numeric_limits<double>::quiet_NaN());
}

// Draws stretches of one colour as one line each.
void DrawPath(const PathPlot::Path& path, double largest, const CellLayout& layout,
              SvgSurface& surface) {
  const size_t count = std::min(path.points.size(), path.values.size());
  const size_t step = std::max<size_t>(1, count / kMostPoints);
  std::vector<Eigen::Vector2d> stretch;
  size_t colour = kColours;
  for (size_t i = 0; i < count; ++i) {
    if (i % step != 0 && path.points[i].allFinite()) continue;  // Gaps stay.
    const size_t next = ColourOf(path.values[i], largest);
    if (next != colour && !stretch.empty()) {
      stretch.push_back(layout.Place(path.points[i]));
      surface.Path(stretch, PaintOf(colour), 4);
      stretch.clear();
    }
    colour = next;
    stretch.push_back(layout.Place(path.points[i]));
  }
  if (stretch.size() == 1) surface.Discs(stretch, 3, PaintOf(colour));
  surface.Path(stretch, PaintOf(colour), 4);
}

void DrawColourBar(const PathPlot& plot, double largest, SvgSurface& surface) {
  constexpr double kLeft_px = 240;
  constexpr double kCell_px = (kPlotWidth_px - kPlotRight_px - kLeft_px) / kColours;
  surface.Text(plot.value_label, {4, 14}, kPlotLetter_px, kInk);
  for (size_t i = 0; i < kColours; ++i) {
    const double x_px = kLeft_px + static_cast<double>(i) * kCell_px;
    surface.Line({x_px, 10}, {x_px + kCell_px + 0.3, 10}, PaintOf(i), 10);
  }
  const Axis axis{{0, largest}, kLeft_px, kPlotWidth_px - kPlotRight_px};
  const Ticks ticks = RoundTicks(axis.range, kMostTicks);
  for (const double value : ticks.values) {
    surface.Text(FormatTick(value, ticks.step), {axis.Place(value), 29}, kPlotLetter_px, kMuted,
                 Anchor::kMiddle);
  }
}

}  // namespace

std::string DrawPathPlot(const PathPlot& plot, SvgStyle style) {
  Bounds bounds;
  if (!FindBounds(plot, bounds)) {
    SvgSurface surface(kPlotWidth_px, 200, style);
    DrawNothing(200, "no values", surface);
    return surface.Finish(plot.title);
  }
  const double width_px = kPlotWidth_px - 8;
  const Eigen::Vector2d size = bounds.Size();
  const double area_px = std::clamp(width_px * size.y() / size.x(), 80.0, kMostHeight_px - kTop_px);
  const double height_px = kTop_px + area_px + 34;
  SvgSurface surface(kPlotWidth_px, height_px, style);
  const CellLayout layout = FitCell(bounds, {{4, kTop_px}, {4 + width_px, kTop_px + area_px}});
  const double largest = EndOfScale(plot);
  for (const PathPlot::Path& path : plot.paths) DrawPath(path, largest, layout, surface);
  for (const std::vector<Eigen::Vector2d>& path : plot.truth) {
    std::vector<Eigen::Vector2d> placed;
    for (const Eigen::Vector2d& x : path) placed.push_back(layout.Place(x));
    surface.DashedPath(placed, kInk, 1.2, 6, 5);
  }
  DrawColourBar(plot, largest, surface);
  DrawScaleBar(plot.unit, layout, {8, height_px - 14}, kPlotLetter_px, surface);
  if (!plot.truth.empty()) {
    surface.DashedPath({{360, height_px - 14}, {400, height_px - 14}}, kInk, 1.2, 6, 5);
    surface.Text("truth", {408, height_px - 10}, kPlotLetter_px, kInk);
  }
  return surface.Finish(plot.title);
}

}  // namespace corbslam
