#include "slam/rendering/map_legend.h"

#include "absl/strings/str_cat.h"
#include "slam/rendering/map_cell.h"

namespace corbslam {
namespace {

constexpr double kLetter_px = 14;

// Draws one entry at `x_px` and returns where the next begins.
double DrawKeyframeEntry(const std::string& label, const Paint& paint, double x_px,
                         Surface& surface) {
  const double y_px = kMapHeader_px - 30;
  surface.FilledPolygon(KeyframeShape({x_px, y_px}, {1, 0}), paint, paint);
  surface.Text(label, {x_px + 20, y_px + 5}, kLetter_px, kInk);
  return x_px + 20 + surface.TextWidth(label, kLetter_px) + 32;
}

// The entry lies behind the others, or beside the title where there is no room.
void DrawTruthEntry(Eigen::Vector2d at_px, Surface& surface) {
  const double width_px = 46 + surface.TextWidth("truth", kLetter_px);
  if (at_px.x() + width_px > surface.width_px()) at_px = {surface.width_px() - width_px - 20, 24};
  surface.DashedPath({at_px, {at_px.x() + 36, at_px.y()}}, kTruth, 2, 8, 5);
  surface.Text("truth", {at_px.x() + 46, at_px.y() + 5}, kLetter_px, kInk);
}

}  // namespace

std::string JoinNames(const MapPicture& picture, bool own) {
  std::string names;
  size_t keyframes = 0;
  for (const MapPicture::Robot& robot : picture.robots) {
    if (robot.is_own != own) continue;
    absl::StrAppend(&names, names.empty() ? "" : ", ", robot.name);
    keyframes += robot.keyframes.size();
  }
  return names.empty() ? "" : absl::StrCat(names, " (", keyframes, ")");
}

void DrawLegend(const MapPicture& picture, Surface& surface) {
  surface.Text(picture.title, {kMapMargin_px, 30}, 16, kInk);
  double x_px = kMapMargin_px;
  const double y_px = kMapHeader_px - 30;
  if (const std::string own = JoinNames(picture, true); !own.empty()) {
    x_px = DrawKeyframeEntry("own keyframes: " + own, kOwn, x_px, surface);
  }
  if (const std::string others = JoinNames(picture, false); !others.empty()) {
    x_px = DrawKeyframeEntry("others' keyframes: " + others, kOthers, x_px, surface);
  }
  const std::string points = absl::StrCat("map points (", picture.points.size(), ")");
  surface.Discs({{x_px + 6, y_px}}, 2.5, kInk);
  surface.Text(points, {x_px + 20, y_px + 5}, kLetter_px, kInk);
  x_px += 20 + surface.TextWidth(points, kLetter_px) + 32;
  if (!picture.truth.empty()) DrawTruthEntry({x_px, y_px}, surface);
}

}  // namespace corbslam
