#include "services/simulation/motion/plane_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace corbslam {
namespace {

struct Corner {
  Eigen::Vector2d place;
  double tangent_m = 0;
};

double Heading(const Eigen::Vector2d& direction) {
  return std::atan2(direction.x(), direction.y());
}

std::vector<Corner> DropRepeated(const std::vector<Corner>& corners) {
  std::vector<Corner> distinct;
  for (const Corner& corner : corners) {
    if (distinct.empty() || (corner.place - distinct.back().place).norm() > 1e-6) {
      distinct.push_back(corner);
    }
  }
  return distinct;
}

// Opens the way: it leads from the middle of the first leg once round, and on.
std::vector<Corner> OpenUp(const std::vector<Corner>& corners, double lead_out_m) {
  const size_t n = corners.size();
  const Eigen::Vector2d middle = 0.5 * (corners[0].place + corners[1].place);
  std::vector<Corner> open = {{middle}};
  for (size_t i = 1; i <= n; ++i) open.push_back(corners[i % n]);
  Eigen::Vector2d at = middle;
  double left_m = std::max(lead_out_m, 1e-3);
  for (size_t i = 1;; ++i) {
    const Corner& next = corners[i % n];
    const double leg_m = (next.place - at).norm();
    if (leg_m >= left_m) {
      open.push_back({at + left_m / leg_m * (next.place - at)});
      return open;
    }
    left_m -= leg_m;
    at = next.place;
    open.push_back(next);
  }
}

// Appends the arc that replaces `corner` on the way from `before` to `after`.
void AppendArc(const Corner& corner, const Eigen::Vector2d& before, const Eigen::Vector2d& after,
               double least_radius_m, std::vector<Eigen::Vector2d>& line) {
  constexpr double kArcStep_rad = 0.02;
  constexpr double kStraight_rad = 1e-3;
  constexpr double kTurningBack_rad = 3.05;
  const double before_m = (corner.place - before).norm();
  const double after_m = (after - corner.place).norm();
  const Eigen::Vector2d in = (corner.place - before) / before_m;
  const Eigen::Vector2d out = (after - corner.place) / after_m;
  const double angle = std::acos(std::clamp(in.dot(out), -1.0, 1.0));
  if (angle < kStraight_rad || angle > kTurningBack_rad) {
    line.push_back(corner.place);
    return;
  }
  const double tangent_m =
      std::min(std::max(corner.tangent_m, least_radius_m * std::tan(angle / 2)),
               0.5 * std::min(before_m, after_m));
  const double radius_m = tangent_m / std::tan(angle / 2);
  const Eigen::Vector2d inwards = (out - out.dot(in) * in).normalized();
  const int steps = std::max(1, static_cast<int>(std::ceil(angle / kArcStep_rad)));
  for (int i = 0; i <= steps; ++i) {
    const double turned = angle * i / steps;
    line.push_back(corner.place - tangent_m * in +
                   radius_m * (std::sin(turned) * in + (1 - std::cos(turned)) * inwards));
  }
}

std::vector<Eigen::Vector2d> RoundCorners(const std::vector<Corner>& corners,
                                          double least_radius_m) {
  std::vector<Eigen::Vector2d> line = {corners.front().place};
  for (size_t i = 1; i + 1 < corners.size(); ++i) {
    AppendArc(corners[i], corners[i - 1].place, corners[i + 1].place, least_radius_m, line);
  }
  line.push_back(corners.back().place);
  return line;
}

// Returns points `spacing_m` apart along the line, beginning with the first one.
std::vector<Eigen::Vector2d> Resample(const std::vector<Eigen::Vector2d>& line, double spacing_m) {
  std::vector<Eigen::Vector2d> points;
  double passed_m = 0;
  for (size_t i = 0; i + 1 < line.size(); ++i) {
    const double leg_m = (line[i + 1] - line[i]).norm();
    for (double next_m = spacing_m * static_cast<double>(points.size()); next_m < passed_m + leg_m;
         next_m = spacing_m * static_cast<double>(points.size())) {
      points.push_back(line[i] + (next_m - passed_m) / leg_m * (line[i + 1] - line[i]));
    }
    passed_m += leg_m;
  }
  return points;
}

// Smooths by a Gaussian along the path; the ends stay where they are.
template <typename Value>
std::vector<Value> Smooth(const std::vector<Value>& values, double deviation) {
  const auto reach = static_cast<ptrdiff_t>(std::ceil(3 * deviation));
  const auto count = static_cast<ptrdiff_t>(values.size());
  if (reach < 1 || count < 2) return values;
  // The values are mirrored at the ends through the end points.
  const auto at = [&](ptrdiff_t i) -> Value {
    const ptrdiff_t last = count - 1;
    if (i < 0) {
      return 2 * values.front() - values[static_cast<size_t>(std::min(-i, last))];
    }
    if (i > last) {
      return 2 * values.back() - values[static_cast<size_t>(std::max(2 * last - i, ptrdiff_t{0}))];
    }
    return values[static_cast<size_t>(i)];
  };
  std::vector<Value> smooth = values;
  for (ptrdiff_t i = 0; i < count; ++i) {
    Value sum = at(i);
    double weights = 1;
    for (ptrdiff_t k = 1; k <= reach; ++k) {
      const double x = static_cast<double>(k) / deviation;
      const double weight = std::exp(-0.5 * x * x);
      sum += weight * (at(i - k) + at(i + k));
      weights += 2 * weight;
    }
    smooth[static_cast<size_t>(i)] = sum / weights;
  }
  return smooth;
}

}  // namespace

std::vector<double> ComputeHeadings(const std::vector<Eigen::Vector2d>& points) {
  std::vector<double> headings;
  headings.reserve(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const size_t before = i == 0 ? 0 : i - 1;
    const size_t after = std::min(i + 1, points.size() - 1);
    double heading = Heading(points[after] - points[before]);
    if (!headings.empty()) {
      const double turn = std::remainder(heading - headings.back(), 2 * std::numbers::pi);
      heading = headings.back() + turn;
    }
    headings.push_back(heading);
  }
  return headings;
}

PlanePath MakePlanePath(const std::vector<Eigen::Vector2d>& waypoints,
                        const PlanePathOptions& options, const std::vector<double>& corners_m) {
  PlanePath path;
  path.spacing_m = options.spacing_m;
  std::vector<Corner> corners;
  for (size_t i = 0; i < waypoints.size(); ++i) {
    corners.push_back({waypoints[i], i < corners_m.size() ? corners_m[i] : options.corner_m});
  }
  corners = DropRepeated(corners);
  if (corners.size() < 2) return path;
  if (options.closed) corners = DropRepeated(OpenUp(corners, options.lead_out_m));
  const std::vector<Eigen::Vector2d> round = RoundCorners(corners, options.least_radius_m);
  const double point_deviation = options.point_smoothing_m / options.spacing_m;
  // Smoothing pulls points together in corners, so they are resampled once more.
  path.points =
      Resample(Smooth(Resample(round, options.spacing_m), point_deviation), options.spacing_m);
  path.headings_rad =
      Smooth(ComputeHeadings(path.points), options.heading_smoothing_m / options.spacing_m);
  return path;
}

}  // namespace corbslam
