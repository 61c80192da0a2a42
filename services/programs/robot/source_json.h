// Writes a source's description and what looks wrong in it as JSON (docs/report.md).
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_SOURCE_JSON_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_SOURCE_JSON_H_

#include <nlohmann/json.hpp>

#include "client_agent/source/source_description.h"
#include "client_agent/source/source_finding.h"

namespace corbslam::services {

nlohmann::ordered_json ToJson(const client_agent::SourceDescription& description);
// Returns an array of {"code", "text"}.
nlohmann::ordered_json ToJson(const client_agent::SourceFindings& findings);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_SOURCE_JSON_H_
