#include "services/observe/tracing/testing/read_trace.h"

#include <fstream>

#include "absl/strings/str_cat.h"

namespace corbslam::testing {

absl::StatusOr<std::vector<nlohmann::json>> ReadTrace(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line) || line != "[") {
    return absl::InvalidArgumentError(absl::StrCat(path, " does not begin with ["));
  }
  std::vector<nlohmann::json> events;
  while (std::getline(file, line)) {
    if (!line.empty() && line.back() == ',') line.pop_back();
    nlohmann::json event = nlohmann::json::parse(line, nullptr, false);
    if (event.is_discarded()) return absl::InvalidArgumentError(absl::StrCat(path, ": ", line));
    events.push_back(std::move(event));
  }
  return events;
}

std::map<std::string, std::set<std::string>> WaysOf(const std::vector<nlohmann::json>& events) {
  std::map<std::string, std::set<std::string>> ways;
  for (const nlohmann::json& event : events) {
    if (event["ph"] == "n") ways[event["args"]["trace"]].insert(event["name"].get<std::string>());
  }
  return ways;
}

}  // namespace corbslam::testing
