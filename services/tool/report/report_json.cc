#include <utility>

#include "services/tool/report/or_null.h"
#include "services/tool/report/report.h"
#include "services/tool/report/report_company.h"
#include "services/tool/report/report_cost.h"

namespace corbslam::services {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const ReportWarning& warning) {
  return {{"robot", warning.robot.empty() ? Json(nullptr) : Json(warning.robot)},
          {"code", warning.code},
          {"text", warning.text}};
}

Json ToJson(const FusedReport& fused) {
  return {{"islands", fused.islands},
          {"robots", fused.robots},
          {"keyframes", fused.keyframes},
          {"map_points", fused.map_points},
          {"ate_m", OrNull(fused.ate_m)},
          {"ate_from_frame_m", OrNull(fused.ate_from_frame_m)},
          {"ate_without_scale_m", OrNull(fused.ate_without_scale_m)},
          {"scale", OrNull(fused.scale)},
          {"t_rel_percent", OrNull(fused.t_rel_percent)},
          {"r_rel_deg_per_100m", OrNull(fused.r_rel_deg_per_100m)}};
}

Json ToJson(const AdjustmentReport& adjustment) {
  return {{"keyframes", adjustment.keyframes},
          {"map_points", adjustment.map_points},
          {"iterations", adjustment.iterations},
          {"ms", adjustment.ms}};
}

Json ToJson(const TransferReport& transfer) {
  return {{"count", transfer.count}, {"bytes", transfer.bytes}, {"ms", transfer.ms}};
}

Json ToJson(const std::optional<RobotMinuteCost>& cost) {
  if (!cost.has_value()) return nullptr;
  return {{"pictures_s", cost->pictures_s},
          {"robot_cpu_s", OrNull(cost->robot_cpu_s)},
          {"servers_cpu_s", Json(cost->servers_cpu_s)},
          {"global_adjustments", cost->global_adjustments}};
}

template <typename T>
Json ToJsonArray(const std::vector<T>& items) {
  Json array = Json::array();
  for (const T& item : items) array.push_back(ToJson(item));
  return array;
}

}  // namespace

std::vector<ReportWarning> AllWarnings(const RunReport& report) {
  std::vector<ReportWarning> all;
  for (const RobotReport& robot : report.robots) {
    for (ReportWarning warning : robot.warnings) {
      warning.robot = robot.name;
      all.push_back(std::move(warning));
    }
  }
  all.insert(all.end(), report.warnings.begin(), report.warnings.end());
  return all;
}

nlohmann::ordered_json ToJson(const RunReport& report) {
  Json servers = Json::object();
  for (const auto& [name, server] : report.servers) {
    servers[name] = {{"peak_rss_mb", server.peak_rss_mb}, {"cpu_s", server.cpu_s}};
  }
  return {{"mission", report.mission},
          {"pace", report.pace},
          {"from_frame", report.from_frame},
          {"robots", ToJsonArray(report.robots)},
          {"warnings", ToJsonArray(AllWarnings(report))},
          {"fused", ToJson(report.fused)},
          {"overlaps",
           {{"queried", report.overlaps.queried},
            {"verified", report.overlaps.verified},
            {"accepted", report.overlaps.accepted}}},
          {"merge_ms", report.merge_ms},
          {"global_ba_ms", ToJsonArray(report.global_ba_ms)},
          {"transfer",
           {{"full_keyframes", ToJson(report.full_keyframes)},
            {"full_map_points", ToJson(report.full_map_points)},
            {"light_keyframes", ToJson(report.light_keyframes)},
            {"light_map_points", ToJson(report.light_map_points)}}},
          {"servers", servers},
          {"per_robot_minute", ToJson(ComputeRobotMinuteCost(report))},
          {"company", CompanyToJson(report)},
          {"wall_s", report.wall_s},
          {"version", report.version},
          {"command", report.command}};
}

}  // namespace corbslam::services
