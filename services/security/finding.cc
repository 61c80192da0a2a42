#include "services/security/finding.h"

#include <algorithm>

#include "absl/strings/str_format.h"

namespace corbslam::services {

std::string ToString(Level level) {
  switch (level) {
    case Level::kOk:
      return "ok";
    case Level::kWarn:
      return "warn";
    case Level::kFail:
      return "fail";
  }
  return "";
}

std::string FormatFindings(const Findings& findings) {
  std::string text;
  for (const Finding& finding : findings) {
    absl::StrAppendFormat(&text, "%-4s  %-12s  %s\n", ToString(finding.level), finding.check,
                          finding.text);
    if (!finding.advice.empty()) absl::StrAppendFormat(&text, "%20s%s\n", "", finding.advice);
  }
  return text;
}

nlohmann::ordered_json ToJson(const Findings& findings) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Finding& finding : findings) {
    json.push_back({{"level", ToString(finding.level)},
                    {"check", finding.check},
                    {"text", finding.text},
                    {"advice", finding.advice}});
  }
  return json;
}

bool AnyFailed(const Findings& findings) {
  return std::any_of(findings.begin(), findings.end(),
                     [](const Finding& finding) { return finding.level == Level::kFail; });
}

}  // namespace corbslam::services
