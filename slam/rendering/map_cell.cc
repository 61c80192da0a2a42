#include "slam/rendering/map_cell.h"

#include <algorithm>

#include "absl/strings/str_format.h"

namespace corbslam {
namespace {

std::vector<Rigid3d> AllKeyframes(const MapPicture& picture) {
  std::vector<Rigid3d> keyframes;
  for (const MapPicture::Robot& robot : picture.robots) {
    keyframes.insert(keyframes.end(), robot.keyframes.begin(), robot.keyframes.end());
  }
  return keyframes;
}

std::vector<Eigen::Vector2d> Flatten(const std::vector<Eigen::Vector3d>& xs,
                                     const PlaneFromWorld& plane_from_world) {
  std::vector<Eigen::Vector2d> flat;
  flat.reserve(xs.size());
  for (const Eigen::Vector3d& x : xs) flat.push_back(plane_from_world * x);
  return flat;
}

void DrawPoints(const std::vector<Eigen::Vector3d>& points, const PlaneFromWorld& plane_from_world,
                const CellLayout& layout, Surface& surface) {
  std::vector<Eigen::Vector2d> placed;
  for (const Eigen::Vector2d& x : Flatten(points, plane_from_world)) {
    if (layout.bounds.Contains(x)) placed.push_back(layout.Place(x));
  }
  surface.Discs(placed, 1.0, kInk);
}

void DrawRobot(const MapPicture::Robot& robot, const PlaneFromWorld& plane_from_world,
               const CellLayout& layout, Surface& surface) {
  std::vector<Eigen::Vector2d> centres;
  for (const Rigid3d& pose : robot.keyframes) {
    centres.push_back(plane_from_world * pose.translation);
  }
  const auto is_seen = [&](size_t i) {
    return i < centres.size() && layout.bounds.Contains(centres[i]);
  };
  const Paint& edge = robot.is_own ? kOwnEdge : kOthersEdge;
  for (const std::vector<Eigen::Vector3d>& path : robot.paths) {
    std::vector<Eigen::Vector2d> placed;
    for (const Eigen::Vector2d& x : Flatten(path, plane_from_world)) {
      placed.push_back(layout.Place(x));
    }
    surface.Path(placed, edge, 1.5);
  }
  for (const auto& [from, to] : robot.edges) {
    if (!is_seen(from) || !is_seen(to)) continue;
    surface.Line(layout.Place(centres[from]), layout.Place(centres[to]), edge, 1.5);
  }
  for (size_t i = 0; i < robot.keyframes.size(); ++i) {
    if (!is_seen(i)) continue;
    const Eigen::Vector3d axis = robot.keyframes[i].rotation * Eigen::Vector3d::UnitZ();
    surface.FilledPolygon(KeyframeShape(layout.Place(centres[i]), plane_from_world * axis),
                          robot.is_own ? kOwn : kOthers, kPaper);
  }
}

void DrawTruth(const std::vector<Eigen::Vector3d>& path, const PlaneFromWorld& plane_from_world,
               const CellLayout& layout, Surface& surface) {
  std::vector<Eigen::Vector2d> placed;
  for (const Eigen::Vector2d& x : Flatten(path, plane_from_world)) {
    placed.push_back(layout.Place(x));
  }
  surface.DashedPath(placed, kTruth, 2, 9, 6);
}

}  // namespace

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

MapView ChooseView(const MapPicture& picture) {
  const std::vector<Rigid3d> keyframes = AllKeyframes(picture);
  MapView view;
  view.plane_from_world = LookFromAbove(keyframes);
  std::vector<Eigen::Vector2d> paths;
  for (const std::vector<Eigen::Vector3d>& path : picture.truth) {
    for (const Eigen::Vector3d& x : path) paths.push_back(view.plane_from_world * x);
  }
  for (const Rigid3d& pose : keyframes) {
    paths.push_back(view.plane_from_world * pose.translation);
  }
  for (const MapPicture::Robot& robot : picture.robots) {
    for (const std::vector<Eigen::Vector3d>& path : robot.paths) {
      for (const Eigen::Vector3d& x : path) paths.push_back(view.plane_from_world * x);
    }
  }
  view.bounds = ChooseBounds(paths, Flatten(picture.points, view.plane_from_world));
  return view;
}

CellLayout FitCell(const Bounds& bounds, const Bounds& rectangle_px) {
  CellLayout layout;
  layout.bounds = bounds;
  const Eigen::Vector2d size = bounds.Size();
  const Eigen::Vector2d room_px = rectangle_px.Size();
  layout.px_per_unit = (room_px.array() / size.array()).minCoeff();
  const Eigen::Vector2d spare = room_px / layout.px_per_unit - size;
  layout.bounds.low -= spare / 2;
  layout.bounds.high += spare / 2;
  layout.origin_px = rectangle_px.low;
  return layout;
}

size_t CountSeen(const std::vector<Eigen::Vector3d>& points, const PlaneFromWorld& plane_from_world,
                 const Bounds& bounds) {
  return static_cast<size_t>(std::ranges::count_if(
      points, [&](const Eigen::Vector3d& x) { return bounds.Contains(plane_from_world * x); }));
}

void DrawMap(const MapPicture& picture, const PlaneFromWorld& plane_from_world,
             const CellLayout& layout, Surface& surface) {
  DrawPoints(picture.points, plane_from_world, layout, surface);
  // Own keyframes are drawn on top.
  for (const bool own : {false, true}) {
    for (const MapPicture::Robot& robot : picture.robots) {
      if (robot.is_own == own) DrawRobot(robot, plane_from_world, layout, surface);
    }
  }
  for (const std::vector<Eigen::Vector3d>& path : picture.truth) {
    DrawTruth(path, plane_from_world, layout, surface);
  }
}

void DrawScaleBar(const std::string& unit, const CellLayout& layout, const Eigen::Vector2d& at_px,
                  double letter_px, Surface& surface) {
  const double length = RoundLength(0.25 * layout.bounds.Size().x());
  const Eigen::Vector2d end_px = at_px + Eigen::Vector2d(length * layout.px_per_unit, 0);
  surface.Line(at_px, end_px, kInk, 2);
  for (const Eigen::Vector2d& x : {at_px, end_px}) {
    surface.Line(x - Eigen::Vector2d(0, 5), x + Eigen::Vector2d(0, 5), kInk, 2);
  }
  surface.Text(absl::StrFormat("%g %s", length, unit), end_px + Eigen::Vector2d(10, 5), letter_px,
               kInk);
}

}  // namespace corbslam
