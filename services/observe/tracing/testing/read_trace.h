// Reads what TraceFile wrote.
#ifndef CORBSLAM_SERVICES_OBSERVE_TRACING_TESTING_READ_TRACE_H_
#define CORBSLAM_SERVICES_OBSERVE_TRACING_TESTING_READ_TRACE_H_

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace corbslam::testing {

// Returns all events, the process' name first. INVALID_ARGUMENT, with the line, if the file is no
// trace.
absl::StatusOr<std::vector<nlohmann::json>> ReadTrace(const std::string& path);

// Returns the names of what happened to each keyframe, by trace id.
std::map<std::string, std::set<std::string>> WaysOf(const std::vector<nlohmann::json>& events);

}  // namespace corbslam::testing

#endif  // CORBSLAM_SERVICES_OBSERVE_TRACING_TESTING_READ_TRACE_H_
