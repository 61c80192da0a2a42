#include "services/programs/robot/robot_report.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "absl/strings/str_cat.h"

namespace corbslam::services {

using client_agent::Agent;
using client_agent::AgentStatus;
using client_agent::AgentTimings;
using client_agent::SourceFinding;
using client_agent::SourceFindings;

Spread ComputeSpread(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const size_t count = values.size();
  const auto p99 = static_cast<size_t>(std::ceil(0.99 * static_cast<double>(count))) - 1;
  return {(values[(count - 1) / 2] + values[count / 2]) / 2,
          std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(count),
          values[p99]};
}

Spread SpreadOf(const BoundedSample& sample) {
  Spread spread = ComputeSpread(sample.values());
  // The values may be a sample; this mean is of all values.
  spread.mean = sample.mean();
  return spread;
}

RobotReport MakeRobotReport(const Agent& agent) {
  const AgentStatus status = agent.GetStatus();
  const AgentTimings timings = agent.GetTimings();
  RobotReport report;
  report.frames = status.frames;
  report.tracked = status.tracked;
  report.lost = status.lost;
  report.local_maps = status.local_maps;
  report.hand_overs = status.hand_overs;
  report.brought_back = status.far.brought_back;
  report.far_recognised = status.far.recognised;
  report.far_unreadable = status.far.unreadable;
  report.resumed_after_s = status.resumed_after_s;
  report.why_not_resumed = status.why_not_resumed;
  report.map_mb = static_cast<double>(status.map_bytes) / (1 << 20);
  report.first_upload_s = status.first_upload_s;
  report.keyframes_held = status.foreign_keyframes;
  report.points_matched_percent = status.foreign_points_percent;
  report.shared_loops_closed = status.foreign_loops_closed;
  report.places_told = status.places_told;
  report.located_after_s = status.located_after_s;
  report.loops_closed = status.loops_closed;
  report.keyframes = status.keyframes;
  report.map_points = status.map_points;
  report.tracking_ms = SpreadOf(timings.tracking_ms);
  report.local_ba_ms = SpreadOf(timings.local_ba_ms);
  report.local_ba_count = static_cast<int>(timings.local_ba_ms.count());
  report.outbox = {status.upload.batches,         status.upload.memory_bytes,
                   status.upload.spool_bytes,     status.upload.spool_syncs,
                   status.upload.lost_local_maps, status.upload.refused_items};
  report.held_back = status.upload.held_back.items;
  return report;
}

std::vector<ReportWarning> ToReportWarnings(const SourceFindings& findings) {
  std::vector<ReportWarning> warnings;
  for (const SourceFinding& finding : findings) {
    warnings.push_back({"", finding.code, finding.text});
  }
  return warnings;
}

std::string DescribeEnd(const RobotReport& report) {
  std::string line = absl::StrCat(
      "done: ", report.tracked, " of ", report.frames, " frames tracked, ", report.dropped,
      " dropped; ", report.keyframes, " keyframes, ", report.map_points, " points in ",
      // One is open from the start on.
      report.keyframes == 0 ? 0 : report.local_maps,
      report.keyframes > 0 && report.local_maps == 1 ? " local map" : " local maps");
  if (report.outbox.batches > 0) {
    absl::StrAppend(&line, "; ", report.outbox.batches,
                    report.outbox.batches == 1 ? " batch" : " batches", " did not reach the store");
  }
  for (const ReportWarning& warning : report.warnings) {
    absl::StrAppend(&line, "; ", warning.code);
  }
  return line;
}

}  // namespace corbslam::services
