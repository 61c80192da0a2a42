#include "services/tool/report/html/map_data.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "slam/rendering/map_cell.h"

namespace corbslam::services {
namespace {

using Json = nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "the page's numbers are little-endian");

constexpr size_t kMostPathPoints = 8'000;
constexpr size_t kMostKeyframes = 6'000;
constexpr double kSteps = 65535;
// Points beyond this share of the middle are left out, beyond the next one not looked at first.
constexpr double kNearShare = 0.98;
constexpr double kLookedAtShare = 0.8;

// The smallest box around what it was shown.
struct Box {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300);
  Eigen::Vector3d high = Eigen::Vector3d::Constant(-1e300);

  void Add(const Eigen::Vector3d& x) {
    if (!x.allFinite()) return;
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  bool IsEmpty() const { return (low.array() > high.array()).any(); }
  bool Contains(const Eigen::Vector3d& x) const {
    return (x.array() >= low.array()).all() && (x.array() <= high.array()).all();
  }
};

// Returns the rotation to the page's frame: x and y as in the picture from above, z upwards.
Eigen::Quaterniond PageFromMap(const MapPicture& map) {
  const PlaneFromWorld plane = ChooseView(map).plane_from_world;
  Eigen::Matrix3d rows;
  rows.row(0) = plane.row(0);
  rows.row(1) = -plane.row(1);
  rows.row(2) = rows.row(0).cross(rows.row(1));
  return Eigen::Quaterniond(rows).normalized();
}

// Returns every how-manyth of `count` things to take, so that there are at most `most`.
size_t Stride(size_t count, size_t most) { return std::max<size_t>(1, (count + most - 1) / most); }

template <typename T>
std::string Encode(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return absl::Base64Escape(bytes);
}

std::string EncodePath(const std::vector<Eigen::Vector3d>& path, const Eigen::Quaterniond& turn) {
  std::vector<float> values;
  const size_t stride = Stride(path.size(), kMostPathPoints);
  for (size_t i = 0; i < path.size(); ++i) {
    // Gaps, which are no numbers, stay.
    if (i % stride != 0 && path[i].allFinite()) continue;
    const Eigen::Vector3d x = turn * path[i];
    for (int axis = 0; axis < 3; ++axis) values.push_back(static_cast<float>(x[axis]));
  }
  return Encode(values);
}

std::string EncodeKeyframes(const std::vector<Rigid3d>& keyframes, const Eigen::Quaterniond& turn) {
  std::vector<float> values;
  for (size_t i = 0; i < keyframes.size(); i += Stride(keyframes.size(), kMostKeyframes)) {
    const Eigen::Vector3d x = turn * keyframes[i].translation;
    const Eigen::Quaterniond q = turn * keyframes[i].rotation;
    for (const double value : {x.x(), x.y(), x.z(), q.w(), q.x(), q.y(), q.z()}) {
      values.push_back(static_cast<float>(value));
    }
  }
  return Encode(values);
}

// Returns the box of everything but points, in the page's frame.
Box PathsBox(const ReportDetail& detail, const Eigen::Quaterniond& turn) {
  Box box;
  for (const MapPicture::Robot& robot : detail.map.robots) {
    for (const Rigid3d& pose : robot.keyframes) box.Add(turn * pose.translation);
    for (const std::vector<Eigen::Vector3d>& path : robot.paths) {
      for (const Eigen::Vector3d& x : path) box.Add(turn * x);
    }
  }
  for (const std::vector<Eigen::Vector3d>& path : detail.map.truth) {
    for (const Eigen::Vector3d& x : path) box.Add(turn * x);
  }
  return box;
}

// Returns the value below which this share of one axis lies.
double Quantile(std::vector<double> values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<size_t>(at)];
}

// Returns the box of what lies between two quantiles of each axis; the points are finite.
Box MiddleOf(const std::vector<Eigen::Vector3d>& points, double share) {
  Box box;
  if (points.empty()) return box;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Eigen::Vector3d& x : points) values.push_back(x[axis]);
    box.low[axis] = Quantile(values, (1 - share) / 2);
    box.high[axis] = Quantile(values, (1 + share) / 2);
  }
  return box;
}

Box Join(const Box& a, const Box& b) { return {a.low.cwiseMin(b.low), a.high.cwiseMax(b.high)}; }

Box Grow(const Box& box, double share) {
  const Eigen::Vector3d margin = share * (box.high - box.low).cwiseMax(1e-3);
  return {box.low - margin, box.high + margin};
}

// Returns the points that are shown, in the page's frame. A few that lie far away would make
// everything else small.
std::vector<Eigen::Vector3d> ChoosePoints(const std::vector<Eigen::Vector3d>& points,
                                          const Eigen::Quaterniond& turn, const Box& paths) {
  std::vector<Eigen::Vector3d> taken;
  for (size_t i = 0; i < points.size(); i += Stride(points.size(), kMostMapPoints)) {
    const Eigen::Vector3d x = turn * points[i];
    if (x.allFinite()) taken.push_back(x);
  }
  const Box near = Grow(Join(paths, MiddleOf(taken, kNearShare)), 0.1);
  std::erase_if(taken, [&](const Eigen::Vector3d& x) { return !near.Contains(x); });
  return taken;
}

Json EncodePoints(const std::vector<Eigen::Vector3d>& kept, size_t total) {
  Box box;
  for (const Eigen::Vector3d& x : kept) box.Add(x);
  if (kept.empty()) box = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones()};
  const Eigen::Vector3d step = ((box.high - box.low) / kSteps).cwiseMax(1e-12);
  std::vector<uint16_t> values;
  for (const Eigen::Vector3d& x : kept) {
    for (int axis = 0; axis < 3; ++axis) {
      const double number = std::round((x[axis] - box.low[axis]) / step[axis]);
      values.push_back(static_cast<uint16_t>(std::clamp(number, 0.0, kSteps)));
    }
  }
  return {{"total", total},
          {"shown", kept.size()},
          {"low", {box.low.x(), box.low.y(), box.low.z()}},
          {"step", {step.x(), step.y(), step.z()}},
          {"data", Encode(values)}};
}

Json EncodeRobots(const ReportDetail& detail, const Eigen::Quaterniond& turn) {
  std::map<std::string, const MapPicture::Robot*> mapped;
  for (const MapPicture::Robot& robot : detail.map.robots) mapped[robot.name] = &robot;
  const std::vector<Paint> paints = RobotPaints(detail);
  Json robots = Json::array();
  for (size_t i = 0; i < detail.robots.size(); ++i) {
    const auto found = mapped.find(detail.robots[i].name);
    const MapPicture::Robot none;
    const MapPicture::Robot& robot = found == mapped.end() ? none : *found->second;
    robots.push_back({{"name", detail.robots[i].name},
                      {"own", robot.is_own},
                      {"paint", paints[i].variable},
                      {"count", robot.keyframes.size()},
                      {"keyframes", EncodeKeyframes(robot.keyframes, turn)},
                      {"path", EncodePath(detail.robots[i].path, turn)}});
  }
  return robots;
}

}  // namespace

std::vector<Paint> RobotPaints(const ReportDetail& detail) {
  std::string own;
  for (const MapPicture::Robot& robot : detail.map.robots) {
    if (robot.is_own) own = robot.name;
  }
  const bool own_is_there = std::ranges::any_of(
      detail.robots, [&](const ReportDetail::Robot& robot) { return robot.name == own; });
  std::vector<Paint> paints;
  size_t next = own_is_there ? 1 : 0;
  for (const ReportDetail::Robot& robot : detail.robots) {
    paints.push_back(own_is_there && robot.name == own ? SeriesPaint(0) : SeriesPaint(next++));
  }
  return paints;
}

std::string WriteMapData(const ReportDetail& detail) {
  const bool is_empty = std::ranges::all_of(
      detail.map.robots, [](const MapPicture::Robot& robot) { return robot.keyframes.empty(); });
  if (is_empty) return "null";
  const Eigen::Quaterniond turn = PageFromMap(detail.map);
  const Box box = PathsBox(detail, turn);
  if (box.IsEmpty()) return "null";
  const std::vector<Eigen::Vector3d> points = ChoosePoints(detail.map.points, turn, box);
  const Box looked_at = Join(box, MiddleOf(points, kLookedAtShare));
  const Eigen::Vector3d centre = 0.5 * (looked_at.low + looked_at.high);
  Json truth = Json::array();
  for (const std::vector<Eigen::Vector3d>& path : detail.map.truth) {
    truth.push_back(EncodePath(path, turn));
  }
  const Json data = {{"centre", {centre.x(), centre.y(), centre.z()}},
                     {"radius", std::max(0.5 * (looked_at.high - looked_at.low).norm(), 1e-3)},
                     {"points", EncodePoints(points, detail.map.points.size())},
                     {"robots", EncodeRobots(detail, turn)},
                     {"truth", truth}};
  // What is no UTF-8 is replaced, and nothing can end the script element or begin a comment in it.
  const std::string text = data.dump(-1, ' ', true, Json::error_handler_t::replace);
  return absl::StrReplaceAll(text, {{"<", "\\u003c"}});
}

}  // namespace corbslam::services
