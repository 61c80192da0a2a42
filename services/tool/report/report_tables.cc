#include "services/tool/report/report_tables.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "services/tool/report/report_cost.h"

namespace corbslam::services {
namespace {

double ToMegabytes(uint64_t bytes) { return static_cast<double>(bytes) / 1e6; }

std::vector<std::string> RobotRow(const RobotReport& robot) {
  return {
      robot.name,
      absl::StrFormat("%d / %d / %d / %d", robot.frames, robot.tracked, robot.dropped, robot.lost),
      FormatOr(robot.ate_m, 4),
      FormatOr(robot.ate_from_frame_m, 4),
      FormatOr(robot.told_ate_m, 4),
      absl::StrFormat("%d, %.3f", robot.told_jumps, robot.told_largest_jump_m),
      absl::StrCat(FormatOr(robot.t_rel_percent, 2), " / ", FormatOr(robot.r_rel_deg_per_100m, 2)),
      absl::StrCat(robot.keyframes),
      absl::StrCat(robot.map_points),
      absl::StrFormat("%.1f / %.1f", robot.tracking_ms.median, robot.tracking_ms.p99),
      absl::StrFormat("%.1f", robot.local_ba_ms.median),
      absl::StrFormat("%d / %.1f %%", robot.keyframes_held, robot.points_matched_percent),
      FormatOr(robot.peak_rss_mb, 0),
      FormatOr(robot.cpu_s, 1),
      absl::StrFormat("%.2f / %.2f", ToMegabytes(robot.bytes_up), ToMegabytes(robot.bytes_down))};
}

std::string JoinTimes(const std::vector<double>& times_ms) {
  if (times_ms.empty()) return "-";
  return absl::StrJoin(times_ms, ", ", [](std::string* text, double ms) {
    absl::StrAppend(text, absl::StrFormat("%.0f", ms));
  });
}

}  // namespace

std::string FormatOr(const std::optional<double>& value, int decimals) {
  return value.has_value() ? absl::StrFormat("%.*f", decimals, *value) : "-";
}

ReportTable RobotTable(const RunReport& report) {
  ReportTable table;
  table.columns = {"robot",
                   "frames / tracked / dropped / lost",
                   "ATE of its own map, m",
                   absl::StrCat("from frame ", report.from_frame),
                   "as told, m",
                   "jumps told, largest, m",
                   "t_rel, % / r_rel, deg/100 m",
                   "keyframes",
                   "points",
                   "tracking, median / p99 ms",
                   "local BA, ms",
                   "shared keyframes / points matched",
                   "memory, MB",
                   "processor, s",
                   "up / down, MB"};
  for (const RobotReport& robot : report.robots) table.rows.push_back(RobotRow(robot));
  return table;
}

ReportTable FusedTable(const RunReport& report) {
  const FusedReport& fused = report.fused;
  ReportTable table;
  table.columns = {"islands",
                   "robots",
                   "keyframes",
                   "points",
                   "ATE, m",
                   absl::StrCat("from frame ", report.from_frame),
                   "without scale, m (scale)",
                   "t_rel, %",
                   "r_rel, deg/100 m"};
  table.rows = {
      {absl::StrCat(fused.islands), absl::StrCat(fused.robots), absl::StrCat(fused.keyframes),
       absl::StrCat(fused.map_points), FormatOr(fused.ate_m, 4),
       FormatOr(fused.ate_from_frame_m, 4),
       absl::StrCat(FormatOr(fused.ate_without_scale_m, 4), " (", FormatOr(fused.scale, 5), ")"),
       FormatOr(fused.t_rel_percent, 2), FormatOr(fused.r_rel_deg_per_100m, 2)}};
  return table;
}

ReportTable TransferTable(const RunReport& report) {
  ReportTable table;
  table.columns = {"sent to the store", "count", "MB", "ms"};
  const std::pair<const char*, const TransferReport*> rows[] = {
      {"full keyframes", &report.full_keyframes},
      {"full map points", &report.full_map_points},
      {"light keyframes", &report.light_keyframes},
      {"light map points", &report.light_map_points}};
  for (const auto& [name, transfer] : rows) {
    table.rows.push_back({name, absl::StrCat(transfer->count),
                          absl::StrFormat("%.2f", ToMegabytes(transfer->bytes)),
                          absl::StrFormat("%.0f", transfer->ms)});
  }
  return table;
}

ReportTable ServerTable(const RunReport& report) {
  ReportTable table;
  table.columns = {"server", "memory, MB", "processor, s"};
  for (const auto& [name, server] : report.servers) {
    table.rows.push_back(
        {name, absl::StrFormat("%.0f", server.peak_rss_mb), absl::StrFormat("%.1f", server.cpu_s)});
  }
  return table;
}

std::vector<std::string> FusionLines(const RunReport& report) {
  std::vector<std::string> lines = {
      absl::StrFormat("overlaps: %d keyframes queried, %d candidates verified, %d accepted",
                      report.overlaps.queried, report.overlaps.verified, report.overlaps.accepted),
      absl::StrCat("merges, ms: ", JoinTimes(report.merge_ms))};
  for (const AdjustmentReport& adjustment : report.global_ba_ms) {
    lines.push_back(absl::StrFormat(
        "global bundle adjustment: %d keyframes, %d points, "
        "%d iterations, %.0f ms",
        adjustment.keyframes, adjustment.map_points, adjustment.iterations, adjustment.ms));
  }
  return lines;
}

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
  return absl::StrCat("A minute of one robot's pictures: ", absl::StrJoin(parts, ", "));
}

}  // namespace corbslam::services
