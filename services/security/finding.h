// Holds what a check found.
#ifndef CORBSLAM_SERVICES_SECURITY_FINDING_H_
#define CORBSLAM_SERVICES_SECURITY_FINDING_H_

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace corbslam::services {

enum class Level { kOk, kWarn, kFail };

struct Finding {
  Level level = Level::kOk;
  std::string check;   // A word or two.
  std::string text;    // What is the case.
  std::string advice;  // What to do; empty for kOk.
};
using Findings = std::vector<Finding>;

// Returns "ok", "warn" or "fail".
std::string ToString(Level level);
// Writes a line for each, "fail  vocabulary   ...", and the advice in a line of its own below.
std::string FormatFindings(const Findings& findings);
nlohmann::ordered_json ToJson(const Findings& findings);
bool AnyFailed(const Findings& findings);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_FINDING_H_
