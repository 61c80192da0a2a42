#include "services/tool/report/report_company.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "services/tool/report/or_null.h"

namespace corbslam::services {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kDecimals = 4;

template <typename Value>
Json Both(const Value& with, const Value& without) {
  return {{"with", with}, {"without", without}};
}
Json Both(const std::optional<double>& with, const std::optional<double>& without) {
  return Both(OrNull(with), OrNull(without));
}

std::string CellOfBoth(const std::optional<double>& with, const std::optional<double>& without) {
  return absl::StrCat(FormatOr(with, kDecimals), " / ", FormatOr(without, kDecimals));
}
std::string CellOfBoth(int with, int without) { return absl::StrCat(with, " / ", without); }

// A robot with company, and the same one alone.
struct Pair {
  const RobotReport& with;
  const RobotReport& without;
};

std::vector<Pair> PairRobots(const RunReport& report) {
  std::vector<Pair> pairs;
  const std::vector<RobotReport>& alone = report.company->alone;
  for (size_t i = 0; i < std::min(report.robots.size(), alone.size()); ++i) {
    pairs.push_back({report.robots[i], alone[i]});
  }
  return pairs;
}

Json RobotToJson(const Pair& robot) {
  const auto& [with, without] = robot;
  return {{"name", with.name},
          {"ate_m", Both(with.ate_m, without.ate_m)},
          {"ate_from_frame_m", Both(with.ate_from_frame_m, without.ate_from_frame_m)},
          {"ate_global_m", Both(with.ate_global_m, without.ate_global_m)},
          {"told_ate_m", Both(with.told_ate_m, without.told_ate_m)},
          {"told_ate_before_m", Both(with.told_ate_before_m, without.told_ate_before_m)},
          {"t_rel_percent", Both(with.t_rel_percent, without.t_rel_percent)},
          {"frames", Both(with.frames, without.frames)},
          {"tracked", Both(with.tracked, without.tracked)},
          {"lost", Both(with.lost, without.lost)},
          {"local_maps", Both(with.local_maps, without.local_maps)},
          {"loops_closed", Both(with.loops_closed, without.loops_closed)},
          {"relocalised", Both(with.relocalised, without.relocalised)},
          {"others",
           {{"keyframes_held", with.keyframes_held},
            {"points_matched_percent", with.points_matched_percent},
            {"loops_closed", with.shared_loops_closed},
            {"relocalised", with.shared_relocalised}}}};
}

// Of the tracked points, how many others made.
std::string SharePercent(const RobotReport& with) {
  return absl::StrFormat("%.1f", with.points_matched_percent);
}

std::vector<std::string> RobotRow(const Pair& robot) {
  const auto& [with, without] = robot;
  return {with.name,
          CellOfBoth(with.ate_global_m, without.ate_global_m),
          CellOfBoth(with.told_ate_m, without.told_ate_m),
          CellOfBoth(with.ate_m, without.ate_m),
          CellOfBoth(with.tracked, without.tracked),
          CellOfBoth(with.lost, without.lost),
          SharePercent(with) + " %",
          absl::StrCat(with.keyframes_held),
          absl::StrCat(with.shared_loops_closed),
          absl::StrCat(with.shared_relocalised)};
}

// Whether anything of what others made came into the robot's own path: of points as much as is
// printed.
bool UsedOthers(const RobotReport& with) {
  return SharePercent(with) != "0.0" || with.shared_loops_closed > 0 || with.shared_relocalised > 0;
}

// What the robot alone has of its own map, which no store has touched.
std::string SayUnfused(const RobotReport& without) {
  if (!without.ate_m.has_value() || without.local_maps != 1) return "";
  return absl::StrFormat(" (%s m in its own map, without any server)",
                         FormatOr(without.ate_m, kDecimals));
}

// Returns ", 12 % less", or that nothing was gained.
std::string SayGain(double with_m, double without_m) {
  const double percent = 100 * (with_m / without_m - 1);
  const std::string size = absl::StrFormat("%.0f", std::abs(percent));
  if (size == "0") return ": company gave no accuracy";
  return absl::StrCat(", ", size, percent < 0 ? " % less" : " % more: company took accuracy");
}

// Of a robot that told no global pose, what it told is in its own frame.
std::string SayTold(const Pair& robot) {
  if (!robot.with.told_ate_m.has_value() || !robot.without.told_ate_m.has_value()) return "";
  return absl::StrFormat("; as told when each frame came %s m and %s m",
                         FormatOr(robot.with.told_ate_m, kDecimals),
                         FormatOr(robot.without.told_ate_m, kDecimals));
}

// Two errors are told apart as far as they are printed. A run alone repeats to the bit in lockstep
// only, so that elsewhere one pair of runs shows no gain and no loss.
std::string JudgeAccuracy(const Pair& robot, bool is_lockstep) {
  const auto& [with, without] = robot;
  // In the global frame; alone the robot's map is fused, too, but nothing of that is told to it.
  if (!with.ate_global_m.has_value() || !without.ate_global_m.has_value()) {
    return absl::StrCat(with.name,
                        ": its accuracy in the global frame is not known both with company and "
                        "alone");
  }
  const std::string with_m = FormatOr(with.ate_global_m, kDecimals);
  const std::string without_m = FormatOr(without.ate_global_m, kDecimals);
  const std::string unfused = SayUnfused(without);
  if (with_m == without_m) {
    return absl::StrFormat("%s: as accurate alone, %s m in the global frame%s", with.name, with_m,
                           unfused);
  }
  std::string line = absl::StrFormat("%s: %s m in the global frame with company, %s m alone%s",
                                     with.name, with_m, without_m, unfused);
  if (!UsedOthers(with)) {
    absl::StrAppend(&line, ", though it used nothing that others made");
  } else if (!is_lockstep) {
    absl::StrAppend(&line, ", which one run of each can't tell from chance");
  } else {
    absl::StrAppend(&line, SayGain(*with.ate_global_m, *without.ate_global_m));
  }
  return line;
}

std::string SayFrames(const Pair& robot) {
  const int more = robot.with.tracked - robot.without.tracked;
  if (more == 0) return "";
  return absl::StrFormat("; %d frames %s tracked", std::abs(more), more > 0 ? "more" : "fewer");
}

std::string SayPoints(const RobotReport& with) {
  if (with.keyframes_held == 0) return "; nothing of others came to it";
  return absl::StrCat(
      "; of the map points that it tracked while it held any of others', others made ",
      SharePercent(with), " %");
}

}  // namespace

nlohmann::ordered_json CompanyToJson(const RunReport& report) {
  if (!report.company.has_value()) return nullptr;
  Json robots = Json::array();
  for (const Pair& robot : PairRobots(report)) robots.push_back(RobotToJson(robot));
  return {{"robots", robots},
          {"fused_ate_m", Both(report.fused.ate_m, report.company->fused_ate_alone_m)},
          {"wall_s", report.company->wall_s}};
}

ReportTable CompanyTable(const RunReport& report) {
  ReportTable table;
  table.columns = {"with company / alone",
                   "global ATE, m",
                   "ATE as told, m",
                   "ATE of its own map, m",
                   "tracked",
                   "lost",
                   "tracked points that others made",
                   "others' keyframes held",
                   "loops closed against others",
                   "found again in others' map"};
  for (const Pair& robot : PairRobots(report)) table.rows.push_back(RobotRow(robot));
  std::vector<std::string> fused(table.columns.size(), "");
  fused[0] = "all, fused";
  fused[1] = CellOfBoth(report.fused.ate_m, report.company->fused_ate_alone_m);
  table.rows.push_back(std::move(fused));
  return table;
}

std::vector<std::string> CompanyLines(const RunReport& report) {
  std::vector<std::string> lines;
  for (const Pair& robot : PairRobots(report)) {
    lines.push_back(absl::StrCat(JudgeAccuracy(robot, report.pace == "step"), SayTold(robot),
                                 SayFrames(robot), SayPoints(robot.with)));
  }
  lines.push_back(
      report.pace == "step"
          ? "In lockstep a run repeats to the bit: what differs is what company did, in this drive."
          : absl::StrCat("One run each: at pace ", report.pace,
                         " errors of one and the same run differ from time to time, too."));
  return lines;
}

}  // namespace corbslam::services
