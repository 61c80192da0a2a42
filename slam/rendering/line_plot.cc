#include "slam/rendering/plot_axes.h"
#include "slam/rendering/plot_parts.h"
#include "slam/rendering/svg_plots.h"

namespace corbslam {
namespace {

constexpr double kArea_px = 200;  // Height of what lies between the axes.
constexpr size_t kColumns = 400;

void DrawSeries(const LinePlot::Series& series, const Axis& x, const Axis& y, SvgSurface& surface) {
  std::vector<Eigen::Vector2d> placed;
  for (const Eigen::Vector2d& point : ThinCurve(series.points, kColumns)) {
    placed.push_back({x.Place(point.x()), y.Place(point.y())});
  }
  surface.Path(placed, series.paint, 1.8);
  if (series.has_marks) surface.Discs(placed, 3.5, series.paint);
}

}  // namespace

std::string DrawLinePlot(const LinePlot& plot, SvgStyle style) {
  LegendEntries entries;
  std::vector<double> xs;
  std::vector<double> ys;
  for (const LinePlot::Series& series : plot.series) {
    entries.push_back({series.name, series.paint});
    for (const Eigen::Vector2d& point : series.points) {
      if (!point.allFinite()) continue;
      xs.push_back(point.x());
      ys.push_back(point.y());
    }
  }
  const SvgSurface measure(kPlotWidth_px, 1, style);
  const double top_px = DrawEntries(entries, 0, measure, nullptr) + 28;
  const double height_px = top_px + kArea_px + kPlotBottom_px;
  SvgSurface surface(kPlotWidth_px, height_px, style);
  DrawEntries(entries, 0, measure, &surface);
  if (ys.empty()) {
    DrawNothing(height_px, "no values", surface);
    return surface.Finish(plot.title);
  }
  const Axis x{RangeOf(xs, false), kPlotLeft_px, kPlotWidth_px - kPlotRight_px};
  Axis y{RangeOf(ys, true), top_px + kArea_px, top_px};
  // A little room above, so that peaks don't lie on the edge.
  y.range.high += 0.04 * (y.range.high - y.range.low);
  DrawAxes(x, plot.x_label, y, plot.y_label, surface);
  for (const LinePlot::Series& series : plot.series) DrawSeries(series, x, y, surface);
  return surface.Finish(plot.title);
}

}  // namespace corbslam
