#include "services/corbslam/agent_report.h"

#include "absl/strings/str_cat.h"

namespace corbslam {
namespace {

// May throw nlohmann::json::exception.
Spread ParseSpread(const nlohmann::json& json) {
  return {json.at("median").get<double>(), json.at("mean").get<double>(),
          json.at("p99").get<double>()};
}

// Likewise.
std::vector<ReportWarning> ParseWarnings(const nlohmann::json& json) {
  std::vector<ReportWarning> warnings;
  for (const nlohmann::json& warning : json) {
    warnings.push_back(
        {"", warning.at("code").get<std::string>(), warning.at("text").get<std::string>()});
  }
  return warnings;
}

Spread SpreadOf(const BoundedSample& sample) {
  Spread spread = ComputeSpread(sample.values());
  // The values may be a sample; the mean is of all.
  spread.mean = sample.mean();
  return spread;
}

}  // namespace

RobotReport MakeRobotReport(const Agent& agent) {
  const AgentStatus status = agent.GetStatus();
  const AgentTimings timings = agent.GetTimings();
  RobotReport report;
  report.frames = status.frames;
  report.tracked = status.tracked;
  report.lost = status.lost;
  report.local_maps = status.local_maps;
  report.first_upload_s = status.first_upload_s;
  report.keyframes_held = status.foreign_keyframes;
  report.points_matched_percent = status.foreign_points_percent;
  report.shared_loops_closed = status.foreign_loops_closed;
  report.loops_closed = status.loops_closed;
  report.keyframes = status.keyframes;
  report.map_points = status.map_points;
  report.tracking_ms = SpreadOf(timings.tracking_ms);
  report.local_ba_ms = SpreadOf(timings.local_ba_ms);
  report.local_ba_count = static_cast<int>(timings.local_ba_ms.count());
  return report;
}

std::vector<ReportWarning> ToReportWarnings(const SourceFindings& findings) {
  std::vector<ReportWarning> warnings;
  for (const SourceFinding& finding : findings)
    warnings.push_back({"", finding.code, finding.text});
  return warnings;
}

absl::StatusOr<RobotReport> ParseRobotReport(const nlohmann::json& json) {
  try {
    RobotReport report;
    json.at("frames").get_to(report.frames);
    json.at("tracked").get_to(report.tracked);
    json.at("dropped").get_to(report.dropped);
    json.at("lost").get_to(report.lost);
    json.at("left_out").get_to(report.left_out);
    json.at("pictures_s").get_to(report.pictures_s);
    report.source_description = json.at("source_description");
    report.warnings = ParseWarnings(json.at("warnings"));
    json.at("local_maps").get_to(report.local_maps);
    if (const auto& first = json.at("first_upload_s"); !first.is_null()) {
      report.first_upload_s = first.get<double>();
    }
    json.at("shared").at("keyframes_held").get_to(report.keyframes_held);
    json.at("shared").at("points_matched_percent").get_to(report.points_matched_percent);
    json.at("shared").at("loops_closed").get_to(report.shared_loops_closed);
    json.at("loops_closed").get_to(report.loops_closed);
    json.at("keyframes").get_to(report.keyframes);
    json.at("map_points").get_to(report.map_points);
    report.tracking_ms = ParseSpread(json.at("tracking_ms"));
    report.local_ba_ms = {json.at("local_ba_ms").get<double>(),
                          json.at("local_ba").at("mean_ms").get<double>(),
                          json.at("local_ba").at("p99_ms").get<double>()};
    json.at("local_ba").at("count").get_to(report.local_ba_count);
    json.at("bytes_up").get_to(report.bytes_up);
    json.at("bytes_down").get_to(report.bytes_down);
    return report;
  } catch (const nlohmann::json::exception& exception) {
    return absl::DataLossError(absl::StrCat("an agent's statistics: ", exception.what()));
  }
}

}  // namespace corbslam
