// Converts what a robot says of itself, to and from the wire.
#ifndef CORBSLAM_SERVICES_CONVERT_AGENT_REPORT_H_
#define CORBSLAM_SERVICES_CONVERT_AGENT_REPORT_H_

#include "absl/status/statusor.h"
#include "corbslam/v1/resources.pb.h"
#include "slam/exchange/agent_report.h"

namespace corbslam::services {

v1::AgentActivity ToProto(AgentActivity activity);
void ToProto(const AgentReport& report, v1::AgentReport* proto);
void ToProto(const MapContradiction& found, v1::MapContradiction* proto);
// INVALID_ARGUMENT names the field, its value and its limits. An activity of a newer version is not
// known.
absl::StatusOr<AgentReport> FromProto(const v1::AgentReport& proto);
absl::StatusOr<MapContradiction> FromProto(const v1::MapContradiction& proto);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_AGENT_REPORT_H_
