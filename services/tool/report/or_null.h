// Writes values that may be missing, as reports do.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_OR_NULL_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_OR_NULL_H_

#include <nlohmann/json.hpp>
#include <optional>

namespace corbslam::services {

// Returns null if there is no value.
inline nlohmann::ordered_json OrNull(const std::optional<double>& value) {
  return value.has_value() ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_OR_NULL_H_
