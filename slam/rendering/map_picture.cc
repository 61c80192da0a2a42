#include "slam/rendering/map_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "slam/rendering/canvas.h"
#include "slam/rendering/view_from_above.h"

namespace corbslam {
namespace {

const Colour kBlack(30, 30, 30);
const Colour kOwn(60, 160, 40);
const Colour kOwnEdge(130, 205, 120);
const Colour kOthers(210, 90, 20);
const Colour kOthersEdge(235, 175, 130);
const Colour kTruth(40, 40, 215);

constexpr double kMargin_px = 36;
constexpr double kHeader_px = 84;
constexpr double kFooter_px = 56;
constexpr double kLetter_px = 14;

// Where the plane of the map lies in the picture.
struct Layout {
  Bounds bounds;
  double px_per_unit = 1;
  int height_px = 0;

  Eigen::Vector2d Place(const Eigen::Vector2d& x) const {
    return (x - bounds.low) * px_per_unit + Eigen::Vector2d(kMargin_px, kHeader_px);
  }
};

// The picture's things in the plane.
struct FlatMap {
  std::vector<Eigen::Vector2d> points;
  std::vector<std::vector<Eigen::Vector2d>> truth;
  std::vector<Eigen::Vector2d> paths;  // All keyframes and truth, which decide the bounds.
};

std::vector<Eigen::Vector2d> Flatten(const std::vector<Eigen::Vector3d>& xs,
                                     const PlaneFromWorld& plane_from_world) {
  std::vector<Eigen::Vector2d> flat;
  flat.reserve(xs.size());
  for (const Eigen::Vector3d& x : xs) flat.push_back(plane_from_world * x);
  return flat;
}

FlatMap FlattenMap(const MapPicture& picture, const PlaneFromWorld& plane_from_world) {
  FlatMap map;
  map.points = Flatten(picture.points, plane_from_world);
  for (const std::vector<Eigen::Vector3d>& path : picture.truth) {
    map.truth.push_back(Flatten(path, plane_from_world));
    map.paths.insert(map.paths.end(), map.truth.back().begin(), map.truth.back().end());
  }
  for (const MapPicture::Robot& robot : picture.robots) {
    for (const Rigid3d& pose : robot.keyframes) {
      map.paths.push_back(plane_from_world * pose.translation);
    }
  }
  return map;
}

// The layout is at most as high as wide.
Layout ArrangePicture(const Bounds& bounds, int width_px) {
  Layout layout;
  layout.bounds = bounds;
  const double plot_px = width_px - 2 * kMargin_px;
  const Eigen::Vector2d size = bounds.Size();
  layout.px_per_unit = std::min(plot_px / size.x(), plot_px / size.y());
  // A map that is higher than wide is centred.
  const double spare = plot_px / layout.px_per_unit - size.x();
  layout.bounds.low.x() -= spare / 2;
  layout.bounds.high.x() += spare / 2;
  layout.height_px =
      static_cast<int>(std::ceil(size.y() * layout.px_per_unit + kHeader_px + kFooter_px));
  return layout;
}

void DrawPoints(const std::vector<Eigen::Vector2d>& points, const Layout& layout, Canvas& canvas) {
  for (const Eigen::Vector2d& x : points) {
    if (layout.bounds.Contains(x)) canvas.Disc(layout.Place(x), 1.0, kBlack);
  }
}

// Returns a wedge that opens to where the camera looks.
std::vector<Eigen::Vector2d> KeyframeShape(const Eigen::Vector2d& centre,
                                           const Eigen::Vector2d& view_direction) {
  constexpr double kLength_px = 8;
  constexpr double kHalfWidth_px = 7;
  if (view_direction.norm() < 0.1) {
    // The camera looks along the line of sight, so it becomes a square.
    return {centre + Eigen::Vector2d(-4, -4), centre + Eigen::Vector2d(4, -4),
            centre + Eigen::Vector2d(4, 4), centre + Eigen::Vector2d(-4, 4)};
  }
  const Eigen::Vector2d ahead = view_direction.normalized();
  const Eigen::Vector2d across(-ahead.y(), ahead.x());
  return {centre, centre + kLength_px * ahead + kHalfWidth_px * across,
          centre + kLength_px * ahead - kHalfWidth_px * across};
}

void DrawRobot(const MapPicture::Robot& robot, const PlaneFromWorld& plane_from_world,
               const Layout& layout, Canvas& canvas) {
  const auto place = [&](size_t i) {
    return layout.Place(plane_from_world * robot.keyframes[i].translation);
  };
  for (const auto& [from, to] : robot.edges) {
    if (from >= robot.keyframes.size() || to >= robot.keyframes.size()) continue;
    canvas.Line(place(from), place(to), robot.is_own ? kOwnEdge : kOthersEdge, 1.5);
  }
  for (size_t i = 0; i < robot.keyframes.size(); ++i) {
    const Eigen::Vector3d axis = robot.keyframes[i].rotation * Eigen::Vector3d::UnitZ();
    canvas.FilledPolygon(KeyframeShape(place(i), plane_from_world * axis),
                         robot.is_own ? kOwn : kOthers, cv::Scalar(255, 255, 255));
  }
}

// Draws one entry at `x_px` and returns where the next begins.
double DrawKeyframeEntry(const std::string& label, const Colour& colour, double x_px,
                         Canvas& canvas) {
  const double y_px = kHeader_px - 30;
  canvas.FilledPolygon(KeyframeShape({x_px, y_px}, {1, 0}), colour, colour);
  canvas.Text(label, {x_px + 20, y_px + 5}, kLetter_px, kBlack);
  return x_px + 20 + Canvas::TextWidth(label, kLetter_px) + 32;
}

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

// The entry lies behind the others, or beside the title where there is no room.
void DrawTruthEntry(Eigen::Vector2d at_px, Canvas& canvas) {
  const double width_px = 46 + Canvas::TextWidth("truth", kLetter_px);
  if (at_px.x() + width_px > canvas.width_px()) at_px = {canvas.width_px() - width_px - 20, 24};
  canvas.DashedPath({at_px, {at_px.x() + 36, at_px.y()}}, kTruth, 2, 8, 5);
  canvas.Text("truth", {at_px.x() + 46, at_px.y() + 5}, kLetter_px, kBlack);
}

void DrawLegend(const MapPicture& picture, Canvas& canvas) {
  canvas.Text(picture.title, {kMargin_px, 30}, 16, kBlack);
  double x_px = kMargin_px;
  const double y_px = kHeader_px - 30;
  if (const std::string own = JoinNames(picture, true); !own.empty()) {
    x_px = DrawKeyframeEntry("own keyframes: " + own, kOwn, x_px, canvas);
  }
  if (const std::string others = JoinNames(picture, false); !others.empty()) {
    x_px = DrawKeyframeEntry("others' keyframes: " + others, kOthers, x_px, canvas);
  }
  const std::string points = absl::StrCat("map points (", picture.points.size(), ")");
  canvas.Disc({x_px + 6, y_px}, 2.5, kBlack);
  canvas.Text(points, {x_px + 20, y_px + 5}, kLetter_px, kBlack);
  x_px += 20 + Canvas::TextWidth(points, kLetter_px) + 32;
  if (!picture.truth.empty()) DrawTruthEntry({x_px, y_px}, canvas);
}

void DrawScaleBar(const MapPicture& picture, const Layout& layout, Canvas& canvas) {
  const double length = RoundLength(0.25 * layout.bounds.Size().x());
  const double y_px = layout.height_px - 24;
  const double end_px = kMargin_px + length * layout.px_per_unit;
  canvas.Line({kMargin_px, y_px}, {end_px, y_px}, kBlack, 2);
  for (const double x_px : {kMargin_px, end_px}) {
    canvas.Line({x_px, y_px - 5}, {x_px, y_px + 5}, kBlack, 2);
  }
  canvas.Text(absl::StrFormat("%g %s", length, picture.unit), {end_px + 10, y_px + 5}, kLetter_px,
              kBlack);
}

std::vector<Rigid3d> AllKeyframes(const MapPicture& picture) {
  std::vector<Rigid3d> keyframes;
  for (const MapPicture::Robot& robot : picture.robots) {
    keyframes.insert(keyframes.end(), robot.keyframes.begin(), robot.keyframes.end());
  }
  return keyframes;
}

cv::Mat Draw(const MapPicture& picture, const std::vector<Rigid3d>& keyframes, int width_px) {
  const PlaneFromWorld plane_from_world = LookFromAbove(keyframes);
  const FlatMap map = FlattenMap(picture, plane_from_world);
  const Layout layout = ArrangePicture(ChooseBounds(map.paths, map.points), width_px);
  Canvas canvas(width_px, layout.height_px);
  DrawPoints(map.points, layout, canvas);
  // Own keyframes are drawn on top.
  for (const bool own : {false, true}) {
    for (const MapPicture::Robot& robot : picture.robots) {
      if (robot.is_own == own) DrawRobot(robot, plane_from_world, layout, canvas);
    }
  }
  for (const std::vector<Eigen::Vector2d>& path : map.truth) {
    std::vector<Eigen::Vector2d> placed;
    for (const Eigen::Vector2d& x : path) placed.push_back(layout.Place(x));
    canvas.DashedPath(placed, kTruth, 2, 9, 6);
  }
  DrawLegend(picture, canvas);
  DrawScaleBar(picture, layout, canvas);
  return canvas.Finish();
}

}  // namespace

absl::StatusOr<cv::Mat> RenderMap(const MapPicture& picture, const MapPictureOptions& options) {
  if (options.width_px < 200 || options.width_px > 10'000) {
    return absl::InvalidArgumentError(
        absl::StrCat("width_px ", options.width_px, " is not 200 to 10000"));
  }
  const std::vector<Rigid3d> keyframes = AllKeyframes(picture);
  if (keyframes.empty()) return absl::InvalidArgumentError("the map has no keyframes");
  try {
    return Draw(picture, keyframes, options.width_px);
  } catch (const cv::Exception& exception) {
    return absl::InternalError(absl::StrCat("drawing the map: ", exception.what()));
  }
}

absl::Status WritePng(const cv::Mat& image, const std::string& path) {
  try {
    if (cv::imwrite(path, image)) return absl::OkStatus();
  } catch (const cv::Exception& exception) {
    return absl::UnavailableError(absl::StrCat("cannot write ", path, ": ", exception.what()));
  }
  return absl::UnavailableError(absl::StrCat("cannot write ", path));
}

}  // namespace corbslam
