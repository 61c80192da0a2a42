
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "services/tool/report/report.h"
#include "services/tool/report/report_cost.h"

namespace corbslam::services {
namespace {

std::string Number(const std::optional<double>& value, int decimals) {
  return value.has_value() ? absl::StrFormat("%.*f", decimals, *value) : "-";
}

double ToMegabytes(uint64_t bytes) { return static_cast<double>(bytes) / 1e6; }

std::string RobotRow(const RobotReport& robot) {
  return absl::StrFormat(
      "| %s | %d / %d / %d / %d | %s | %s | %s / %s | %d | %d | %.1f / %.1f | %.1f | %d / %.1f %% "
      "| "
      "%s | %s | %.2f / %.2f |\n",
      robot.name, robot.frames, robot.tracked, robot.dropped, robot.lost, Number(robot.ate_m, 4),
      Number(robot.ate_from_frame_m, 4), Number(robot.t_rel_percent, 2),
      Number(robot.r_rel_deg_per_100m, 2), robot.keyframes, robot.map_points,
      robot.tracking_ms.median, robot.tracking_ms.p99, robot.local_ba_ms.median,
      robot.keyframes_held, robot.points_matched_percent, Number(robot.peak_rss_mb, 0),
      Number(robot.cpu_s, 1), ToMegabytes(robot.bytes_up), ToMegabytes(robot.bytes_down));
}

std::string RobotTable(const RunReport& report) {
  std::string table = absl::StrFormat(
      "| robot | frames / tracked / dropped / lost | ATE, m | from frame %d | "
      "t_rel, %% / r_rel, deg/100 m | keyframes | points | tracking, median / p99 ms | "
      "local BA, ms | shared keyframes / points matched | memory, MB | processor, s | "
      "up / down, MB |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
      report.from_frame);
  for (const RobotReport& robot : report.robots) absl::StrAppend(&table, RobotRow(robot));
  return table;
}

std::string FusedTable(const RunReport& report) {
  const FusedReport& fused = report.fused;
  return absl::StrFormat(
      "| islands | robots | keyframes | points | ATE, m | from frame %d | without scale, m (scale) "
      "| t_rel, %% | r_rel, deg/100 m |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n"
      "| %d | %d | %d | %d | %s | %s | %s (%s) | %s | %s |\n",
      report.from_frame, fused.islands, fused.robots, fused.keyframes, fused.map_points,
      Number(fused.ate_m, 4), Number(fused.ate_from_frame_m, 4),
      Number(fused.ate_without_scale_m, 4), Number(fused.scale, 5), Number(fused.t_rel_percent, 2),
      Number(fused.r_rel_deg_per_100m, 2));
}

std::string JoinTimes(const std::vector<double>& times_ms) {
  if (times_ms.empty()) return "-";
  return absl::StrJoin(times_ms, ", ", [](std::string* text, double ms) {
    absl::StrAppend(text, absl::StrFormat("%.0f", ms));
  });
}

std::string FusionList(const RunReport& report) {
  std::string list = absl::StrFormat(
      "* overlaps: %d keyframes queried, %d candidates verified, %d accepted\n* merges, ms: %s\n",
      report.overlaps.queried, report.overlaps.verified, report.overlaps.accepted,
      JoinTimes(report.merge_ms));
  for (const AdjustmentReport& adjustment : report.global_ba_ms) {
    absl::StrAppend(&list, absl::StrFormat("* global bundle adjustment: %d keyframes, %d points, "
                                           "%d iterations, %.0f ms\n",
                                           adjustment.keyframes, adjustment.map_points,
                                           adjustment.iterations, adjustment.ms));
  }
  return list;
}

std::string TransferTable(const RunReport& report) {
  std::string table = "| sent to the store | count | MB | ms |\n| --- | --- | --- | --- |\n";
  const std::pair<const char*, const TransferReport*> rows[] = {
      {"full keyframes", &report.full_keyframes},
      {"full map points", &report.full_map_points},
      {"light keyframes", &report.light_keyframes},
      {"light map points", &report.light_map_points}};
  for (const auto& [name, transfer] : rows) {
    absl::StrAppend(&table, absl::StrFormat("| %s | %d | %.2f | %.0f |\n", name, transfer->count,
                                            ToMegabytes(transfer->bytes), transfer->ms));
  }
  return table;
}

std::string ServerTable(const RunReport& report) {
  if (report.servers.empty()) return "";
  std::string table = "\n| server | memory, MB | processor, s |\n| --- | --- | --- |\n";
  for (const auto& [name, server] : report.servers) {
    absl::StrAppend(
        &table, absl::StrFormat("| %s | %.0f | %.1f |\n", name, server.peak_rss_mb, server.cpu_s));
  }
  return table;
}

// Returns an empty text if no time is known.
std::string CostLine(const RunReport& report) {
  const std::optional<RobotMinuteCost> cost = ComputeRobotMinuteCost(report);
  if (!cost.has_value()) return "";
  std::vector<std::string> parts;
  if (cost->robot_cpu_s.has_value()) {
    parts.push_back(absl::StrFormat("robot %.1f s of processor", *cost->robot_cpu_s));
  }
  for (const auto& [name, cpu_s] : cost->servers_cpu_s) {
    parts.push_back(absl::StrFormat("%s %.1f s of processor", name, cpu_s));
  }
  parts.push_back(absl::StrFormat("%.1f global adjustments", cost->global_adjustments));
  return absl::StrCat("\nA minute of one robot's pictures: ", absl::StrJoin(parts, ", "), "\n");
}

// Returns a line for each warning; an empty text if there is none.
std::string WarningList(const RunReport& report) {
  const std::vector<ReportWarning> warnings = AllWarnings(report);
  if (warnings.empty()) return "";
  std::string list = "\nWarnings:\n\n";
  for (const ReportWarning& warning : warnings) {
    const std::string who = warning.robot.empty() ? "" : absl::StrCat(warning.robot, ": ");
    absl::StrAppend(&list, "* ", who, absl::StrReplaceAll(warning.text, {{"\n", " "}}), " [",
                    warning.code, "]\n");
  }
  return list;
}

}  // namespace

std::string ToMarkdown(const RunReport& report) {
  return absl::StrCat(
      "# Several robots, one map\n\n", RobotTable(report), WarningList(report),
      "\nThe fused map:\n\n", FusedTable(report), "\n", FusionList(report), "\n",
      TransferTable(report), ServerTable(report), CostLine(report),
      absl::StrFormat("\nMission %s, pace %s, %.1f s, corbslam %s\n\n    %s\n", report.mission,
                      report.pace, report.wall_s, report.version, report.command));
}

}  // namespace corbslam::services
