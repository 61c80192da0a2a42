#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "slam/rendering/plot_axes.h"
#include "slam/rendering/plot_parts.h"
#include "slam/rendering/svg_plots.h"
#include "slam/rendering/svg_text.h"

namespace corbslam {
namespace {

constexpr size_t kMostBars = 40;
constexpr double kRow_px = 24;
constexpr double kTop_px = 8;
constexpr double kLeastBar_px = 2;

// Returns how much room the names take on the left.
double NameWidth(const std::vector<std::string>& names, const SvgSurface& measure) {
  double width_px = 30;
  for (const std::string& name : names) {
    width_px = std::max(width_px, measure.TextWidth(name, kPlotLetter_px));
  }
  return std::min(width_px, 200.0) + 12;
}

void DrawRowName(const std::string& name, double left_px, double y_px, SvgSurface& surface) {
  surface.Text(name, {left_px - 8, y_px + kPlotLetter_px / 2}, kPlotLetter_px, kInk, Anchor::kEnd);
}

// Draws the ticks below rows that end at `y_px`.
void DrawXAxis(const Axis& x, const std::string& label, double y_px, SvgSurface& surface) {
  const Ticks ticks = RoundTicks(x.range, 6);
  for (const double value : ticks.values) {
    surface.Line({x.Place(value), kTop_px}, {x.Place(value), y_px + 4}, kGrid, 1);
    surface.Text(FormatTick(value, ticks.step), {x.Place(value), y_px + 8 + kPlotLetter_px},
                 kPlotLetter_px, kMuted, Anchor::kMiddle);
  }
  surface.Text(label, {x.high_px, y_px + 16 + 2.2 * kPlotLetter_px}, kPlotLetter_px, kInk,
               Anchor::kEnd);
}

struct Rows {
  double left_px = 0;
  double bottom_px = 0;
  double height_px = 0;
};

Rows ArrangeRows(const std::vector<std::string>& names, const SvgSurface& measure) {
  Rows rows;
  rows.left_px = NameWidth(names, measure);
  rows.bottom_px = kTop_px + static_cast<double>(names.size()) * kRow_px + 4;
  rows.height_px = rows.bottom_px + kPlotBottom_px;
  return rows;
}

double RowCentre(size_t row) { return kTop_px + (static_cast<double>(row) + 0.5) * kRow_px; }

}  // namespace

std::string DrawBarPlot(const BarPlot& plot, SvgStyle style) {
  const size_t count = std::min(plot.bars.size(), kMostBars);
  std::vector<std::string> names;
  std::vector<double> values;
  double text_px = 0;  // Room for the values behind the bars.
  const SvgSurface measure(kPlotWidth_px, 1, style);
  for (size_t i = 0; i < count; ++i) {
    names.push_back(Shorten(plot.bars[i].name, kMostNameLetters));
    values.push_back(std::max(0.0, plot.bars[i].value));
    text_px = std::max(text_px, measure.TextWidth(plot.bars[i].text, kPlotLetter_px));
  }
  const Rows rows = ArrangeRows(names, measure);
  SvgSurface surface(kPlotWidth_px, count == 0 ? 120 : rows.height_px, style);
  if (count == 0) {
    DrawNothing(120, "no values", surface);
    return surface.Finish(plot.title);
  }
  const Axis x{RangeOf(values, true), rows.left_px,
               kPlotWidth_px - std::max(kPlotRight_px, text_px + 10)};
  DrawXAxis(x, plot.x_label, rows.bottom_px, surface);
  for (size_t i = 0; i < count; ++i) {
    const double y_px = RowCentre(i);
    const double end_px = std::isfinite(values[i]) ? x.Place(values[i]) : x.low_px;
    surface.Line({x.low_px, y_px}, {end_px, y_px}, plot.bars[i].paint, 13);
    surface.Text(plot.bars[i].text, {end_px + 6, y_px + kPlotLetter_px / 2}, kPlotLetter_px, kInk);
    DrawRowName(names[i], rows.left_px, y_px, surface);
  }
  if (plot.bars.size() > count) {
    surface.Text(absl::StrCat("and ", plot.bars.size() - count, " more"),
                 {4, rows.bottom_px + 16 + 2.2 * kPlotLetter_px}, kPlotLetter_px, kMuted);
  }
  return surface.Finish(plot.title);
}

std::string DrawTimeline(const Timeline& timeline, SvgStyle style) {
  std::vector<std::string> names;
  std::vector<double> times;
  for (const Timeline::Lane& lane : timeline.lanes) {
    names.push_back(Shorten(lane.name, kMostNameLetters));
    for (const Timeline::Span& span : lane.spans) {
      times.insert(times.end(), {span.begin, span.end});
    }
    times.insert(times.end(), lane.marks.begin(), lane.marks.end());
  }
  const SvgSurface measure(kPlotWidth_px, 1, style);
  const Rows rows = ArrangeRows(names, measure);
  SvgSurface surface(kPlotWidth_px, times.empty() ? 120 : rows.height_px, style);
  if (times.empty()) {
    DrawNothing(120, "nothing happened", surface);
    return surface.Finish(timeline.title);
  }
  const Axis x{RangeOf(times, false), rows.left_px, kPlotWidth_px - kPlotRight_px};
  DrawXAxis(x, timeline.x_label, rows.bottom_px, surface);
  for (size_t i = 0; i < timeline.lanes.size(); ++i) {
    const double y_px = RowCentre(i);
    for (const Timeline::Span& span : timeline.lanes[i].spans) {
      // Also a moment can be seen.
      const double begin_px = x.Place(span.begin);
      surface.Line({begin_px, y_px}, {std::max(x.Place(span.end), begin_px + kLeastBar_px), y_px},
                   timeline.lanes[i].paint, 13);
    }
    for (const double mark : timeline.lanes[i].marks) {
      surface.Line({x.Place(mark), y_px - 9}, {x.Place(mark), y_px + 9}, kInk, 1.5);
    }
    DrawRowName(names[i], rows.left_px, y_px, surface);
  }
  return surface.Finish(timeline.title);
}

}  // namespace corbslam
