#include "slam/rendering/plot_parts.h"

#include <algorithm>
#include <set>

#include "slam/rendering/plot_axes.h"
#include "slam/rendering/svg_text.h"

namespace corbslam {
namespace {

using Points = std::vector<Eigen::Vector2d>;

// Appends what is kept of points [first, end), all of which are finite.
void KeepExtremes(const Points& points, size_t first, size_t end, Points& kept) {
  size_t lowest = first;
  size_t highest = first;
  for (size_t i = first; i < end; ++i) {
    if (points[i].y() < points[lowest].y()) lowest = i;
    if (points[i].y() > points[highest].y()) highest = i;
  }
  for (const size_t i : std::set<size_t>{first, lowest, highest, end - 1}) {
    kept.push_back(points[i]);
  }
}

}  // namespace

double DrawEntries(const LegendEntries& entries, double top_px, const Surface& measure,
                   Surface* surface) {
  constexpr double kRow_px = 20;
  double x_px = 4;
  double y_px = top_px + kRow_px;
  for (const auto& [name, paint] : entries) {
    const std::string shown = Shorten(name, kMostNameLetters);
    const double width_px = 26 + measure.TextWidth(shown, kPlotLetter_px) + 16;
    if (x_px > 4 && x_px + width_px > kPlotWidth_px) {
      x_px = 4;
      y_px += kRow_px;
    }
    if (surface != nullptr) {
      surface->Line({x_px, y_px - 4}, {x_px + 18, y_px - 4}, paint, 3);
      surface->Text(shown, {x_px + 26, y_px}, kPlotLetter_px, kInk);
    }
    x_px += width_px;
  }
  return entries.empty() ? top_px : y_px + 6;
}

void DrawNothing(double height_px, const std::string& why, Surface& surface) {
  surface.Text(why, {kPlotWidth_px / 2, height_px / 2}, kPlotLetter_px, kMuted, Anchor::kMiddle);
}

Points ThinCurve(const Points& points, size_t columns) {
  if (points.size() <= 4 * columns) return points;
  const size_t stride = (points.size() + columns - 1) / columns;
  Points kept;
  for (size_t first = 0; first < points.size();) {
    if (!points[first].allFinite()) {
      if (kept.empty() || kept.back().allFinite()) kept.push_back(points[first]);
      ++first;
      continue;
    }
    size_t end = first;
    while (end < points.size() && end < first + stride && points[end].allFinite()) ++end;
    KeepExtremes(points, first, end, kept);
    first = end;
  }
  return kept;
}

}  // namespace corbslam
