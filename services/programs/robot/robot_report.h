// What a robot says of itself, as part of the report.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_AGENT_REPORT_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_AGENT_REPORT_H_

#include <nlohmann/json.hpp>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/agent/agent.h"
#include "client_agent/source/source_finding.h"
#include "services/tool/report/report.h"

namespace corbslam {

// Without name, source, dropped frames, bytes, memory, processor time and accuracy.
RobotReport MakeRobotReport(const Agent& agent);

// As the report has them, of no robot yet.
std::vector<ReportWarning> ToReportWarnings(const SourceFindings& findings);

// What `client_agent --stats` writes. DATA_LOSS names the field that is missing or of another kind.
absl::StatusOr<RobotReport> ParseRobotReport(const nlohmann::json& json);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_AGENT_REPORT_H_
