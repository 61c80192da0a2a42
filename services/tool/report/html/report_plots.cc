#include "services/tool/report/html/report_plots.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "services/tool/report/html/long_interval.h"
#include "slam/rendering/paint.h"
#include "slam/rendering/svg_plots.h"
#include "slam/rendering/svg_text.h"
#include "slam/rendering/view_from_above.h"

namespace corbslam::services {
namespace {

constexpr SvgStyle kPlotStyle = SvgStyle::kInAPage;

std::string Plots(const std::string& figures) {
  return absl::StrCat("<div class=\"plots\">\n", figures, "</div>\n");
}

// Returns each robot's colour, as the viewer's page has it.
std::vector<Paint> RobotPaints(const ReportDetail& detail) {
  std::set<std::string> names;
  for (const ReportDetail::Robot& robot : detail.robots) names.insert(robot.name);
  const std::map<std::string, size_t> numbers = NumberRobots(names);
  std::vector<Paint> paints;
  for (const ReportDetail::Robot& robot : detail.robots) {
    paints.push_back(SeriesPaint(numbers.at(robot.name)));
  }
  return paints;
}

bool HasErrors(const ReportDetail& detail) {
  return std::ranges::any_of(
      detail.robots, [](const ReportDetail::Robot& robot) { return !robot.errors.empty(); });
}

bool AreGlobal(const ReportDetail& detail) {
  return std::ranges::all_of(detail.robots, [](const ReportDetail::Robot& robot) {
    return robot.errors.empty() || robot.errors_are_global;
  });
}

double SecondsSince(int64_t begin_ns, int64_t time_ns) {
  return 1e-9 * static_cast<double>(time_ns - begin_ns);
}

// Returns whether the robot was lost between two poses that have errors, or the truth was.
class GapFinder {
 public:
  explicit GapFinder(const std::vector<PoseError>& errors) {
    std::vector<double> intervals_s;
    for (size_t i = 1; i < errors.size(); ++i) {
      intervals_s.push_back(SecondsSince(errors[i - 1].timestamp_ns, errors[i].timestamp_ns));
    }
    longest_s_ = std::max(longest_s_, LongInterval_s(std::move(intervals_s)));
  }
  bool IsBetween(const PoseError& before, const PoseError& after) const {
    return SecondsSince(before.timestamp_ns, after.timestamp_ns) > longest_s_;
  }

 private:
  double longest_s_ = 1;  // Shorter gaps are not worth one in the picture.
};

// Lines have a gap where frames were lost.
std::vector<Eigen::Vector2d> ErrorCurve(const ReportDetail::Robot& robot) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const GapFinder gaps(robot.errors);
  std::vector<Eigen::Vector2d> curve;
  for (size_t i = 0; i < robot.errors.size(); ++i) {
    const PoseError& error = robot.errors[i];
    if (i > 0 && gaps.IsBetween(robot.errors[i - 1], error)) curve.push_back({kNaN, kNaN});
    curve.push_back({SecondsSince(robot.begin_ns, error.timestamp_ns), error.error_m});
  }
  return curve;
}

std::string ErrorOverTime(const ReportDetail& detail, const std::vector<Paint>& paints) {
  LinePlot plot;
  plot.title = "Absolute error over time, by robot";
  plot.x_label = "since the robot's first tracked frame (s)";
  plot.y_label = "absolute error (m)";
  for (size_t i = 0; i < detail.robots.size(); ++i) {
    if (detail.robots[i].errors.empty()) continue;
    plot.series.push_back({detail.robots[i].name, paints[i], ErrorCurve(detail.robots[i]), false});
  }
  return Figure("Absolute error over time",
                AreGlobal(detail)
                    ? "All robots under one alignment with the truth."
                    : "Robots outside the global frame under alignments of their own.",
                DrawLinePlot(plot, kPlotStyle));
}

// Adds a robot's path and the true one, both with gaps where it was lost.
void AddPath(const ReportDetail::Robot& robot, const PlaneFromWorld& plane, PathPlot& plot) {
  const Eigen::Vector2d gap = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  const GapFinder gaps(robot.errors);
  PathPlot::Path& path = plot.paths.emplace_back();
  std::vector<Eigen::Vector2d>& true_path = plot.truth.emplace_back();
  for (size_t i = 0; i < robot.errors.size(); ++i) {
    const PoseError& error = robot.errors[i];
    if (i > 0 && gaps.IsBetween(robot.errors[i - 1], error)) {
      path.points.push_back(gap);
      path.values.push_back(gap.x());
      true_path.push_back(gap);
    }
    path.points.push_back(plane * error.aligned);
    path.values.push_back(error.error_m);
    true_path.push_back(plane * error.truth.translation);
  }
}

// `robots` have their truths in one frame.
std::string ErrorOnPaths(const std::vector<const ReportDetail::Robot*>& robots,
                         const std::string& caption, const std::string& note) {
  std::vector<Rigid3d> truth;
  for (const ReportDetail::Robot* robot : robots) {
    for (const PoseError& error : robot->errors) truth.push_back(error.truth);
  }
  if (truth.empty()) return "";
  const PlaneFromWorld plane = LookFromAbove(truth);
  PathPlot plot;
  plot.title = caption;
  plot.value_label = "absolute error (m)";
  for (const ReportDetail::Robot* robot : robots) AddPath(*robot, plane, plot);
  return Figure(EscapeMarkup(caption), note, DrawPathPlot(plot, kPlotStyle));
}

// A robot that nothing connects with the others, or that was in another world, gets a picture of
// its own: where it would lie in theirs means nothing.
std::string ErrorOnPaths(const ReportDetail& detail) {
  constexpr size_t kMostApart = 8;
  std::vector<const ReportDetail::Robot*> together;
  std::vector<const ReportDetail::Robot*> apart;
  for (const ReportDetail::Robot& robot : detail.robots) {
    if (!robot.errors.empty()) (robot.errors_are_global ? together : apart).push_back(&robot);
  }
  const std::string caption = "Trajectories from above, by error";
  std::string figures = ErrorOnPaths(together, caption, "");
  for (size_t i = 0; i < std::min(apart.size(), kMostApart); ++i) {
    absl::StrAppend(&figures, ErrorOnPaths({apart[i]}, absl::StrCat(caption, ": ", apart[i]->name),
                                           "Outside the global frame, under its own alignment."));
  }
  return figures;
}

std::string ErrorByLength(const ReportDetail& detail, const std::vector<Paint>& paints) {
  LinePlot plot;
  plot.title = "Relative error by the length of the segment, by robot";
  plot.x_label = "length of the segment (m)";
  plot.y_label = "relative error (%)";
  for (size_t i = 0; i < detail.robots.size(); ++i) {
    if (detail.robots[i].by_length.empty()) continue;
    LinePlot::Series& series = plot.series.emplace_back();
    series = {detail.robots[i].name, paints[i], {}, true};
    for (const LengthError& error : detail.robots[i].by_length) {
      series.points.push_back({error.length_m, error.error.translation_percent});
    }
  }
  if (plot.series.empty()) {
    return "<p class=\"note\">No robot travelled 100 m, the shortest segment of which relative "
           "errors are taken.</p>\n";
  }
  return Figure("Drift", "KITTI's relative error over segments of one length.",
                DrawLinePlot(plot, kPlotStyle));
}

// What a bar stands for is one number of each robot.
std::string RobotBars(const ReportDetail& detail, const std::vector<Paint>& paints,
                      const std::string& title, const std::string& label,
                      const std::vector<double>& values, int decimals) {
  BarPlot plot;
  plot.title = title;
  plot.x_label = label;
  for (size_t i = 0; i < std::min(values.size(), detail.robots.size()); ++i) {
    plot.bars.push_back({detail.robots[i].name, paints[i], values[i],
                         absl::StrFormat("%.*f", decimals, values[i])});
  }
  return Figure(title, "", DrawBarPlot(plot, kPlotStyle));
}

std::string TrackingTimeline(const ReportDetail& detail, const std::vector<Paint>& paints) {
  Timeline timeline;
  timeline.title = "When each robot tracked its frames";
  timeline.x_label = "since the robot's first tracked frame (s)";
  for (size_t i = 0; i < detail.robots.size(); ++i) {
    Timeline::Lane& lane = timeline.lanes.emplace_back();
    lane.name = detail.robots[i].name;
    lane.paint = paints[i];
    for (const ReportDetail::Tracked& tracked : detail.robots[i].tracked) {
      lane.spans.push_back({tracked.begin_s, tracked.end_s});
    }
    lane.marks = detail.robots[i].local_maps_s;
  }
  return Figure(
      "Tracking",
      "Bars: frames were tracked. Strokes: the robot was lost and began a further local map.",
      DrawTimeline(timeline, kPlotStyle));
}

}  // namespace

std::string Figure(const std::string& caption, const std::string& note, const std::string& svg) {
  return absl::StrCat("<figure><figcaption>", caption,
                      note.empty() ? "" : absl::StrCat("<span class=\"note\">", note, "</span>"),
                      "</figcaption>\n", svg, "</figure>\n");
}

std::string AccuracyPlots(const ReportDetail& detail) {
  if (!HasErrors(detail)) {
    return "<p class=\"note\">There is no ground truth beside what the robots saw, or too little "
           "of "
           "it: nobody knows how far off they are.</p>\n";
  }
  const std::vector<Paint> paints = RobotPaints(detail);
  return Plots(absl::StrCat(ErrorOverTime(detail, paints), ErrorOnPaths(detail),
                            ErrorByLength(detail, paints)));
}

std::string RobotPlots(const RunReport& report, const ReportDetail& detail) {
  std::vector<double> keyframes;
  std::vector<double> up_mb;
  std::vector<double> down_mb;
  for (const RobotReport& robot : report.robots) {
    keyframes.push_back(robot.keyframes);
    up_mb.push_back(1e-6 * static_cast<double>(robot.bytes_up));
    down_mb.push_back(1e-6 * static_cast<double>(robot.bytes_down));
  }
  const std::vector<Paint> paints = RobotPaints(detail);
  return Plots(absl::StrCat(
      TrackingTimeline(detail, paints),
      RobotBars(detail, paints, "Keyframes", "keyframes", keyframes, 0),
      RobotBars(detail, paints, "Sent to the store", "sent (MB)", up_mb, 2),
      RobotBars(detail, paints, "Received from the store", "received (MB)", down_mb, 2)));
}

std::string FusionPlots(const RunReport& report) {
  BarPlot plot;
  plot.title = "How long merges and global bundle adjustments took";
  plot.x_label = "time (ms)";
  for (size_t i = 0; i < report.merge_ms.size(); ++i) {
    plot.bars.push_back({absl::StrCat("merge ", i + 1), SeriesPaint(0), report.merge_ms[i],
                         absl::StrFormat("%.0f", report.merge_ms[i])});
  }
  for (size_t i = 0; i < report.global_ba_ms.size(); ++i) {
    const AdjustmentReport& adjustment = report.global_ba_ms[i];
    plot.bars.push_back(
        {absl::StrCat("adjustment ", i + 1), SeriesPaint(1), adjustment.ms,
         absl::StrFormat("%.0f, %d keyframes", adjustment.ms, adjustment.keyframes)});
  }
  if (plot.bars.empty()) return "<p class=\"note\">Nothing was merged or adjusted.</p>\n";
  return Plots(Figure("Merges and global bundle adjustments, oldest first", "",
                      DrawBarPlot(plot, kPlotStyle)));
}

std::string FlatMap(const MapPicture& map, size_t most_points, int width_px) {
  MapPicture thinned = map;
  const size_t step = std::max<size_t>(1, (map.points.size() + most_points - 1) / most_points);
  thinned.points.clear();
  thinned.all_points = map.points.size();
  for (size_t i = 0; i < map.points.size(); i += step) thinned.points.push_back(map.points[i]);
  MapPictureOptions options;
  options.width_px = width_px;
  const absl::StatusOr<std::string> svg = RenderMapSvg(thinned, kPlotStyle, options);
  return svg.ok() ? *svg : "<p class=\"note\">No robot brought anything: there is no map.</p>\n";
}

}  // namespace corbslam::services
