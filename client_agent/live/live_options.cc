#include "client_agent/live/live_options.h"

#include <glog/logging.h>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "client_agent/source/rig/rig_file.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

constexpr double kMostWithin_ms = 1000;

absl::StatusOr<bool> ParseFlag(absl::string_view key, absl::string_view value) {
  if (value != "" && value != "0" && value != "1") return BadLiveOption(key, value, "0 or 1");
  return value != "0";
}

}  // namespace

absl::Status BadLiveOption(absl::string_view key, absl::string_view value,
                           absl::string_view wanted) {
  return absl::InvalidArgumentError(
      absl::StrCat("source option ", key, "=", value, ": wants ", wanted));
}

std::vector<absl::string_view> LiveOptionNames() {
  return {"rig", "pair_within_ms", "register", "restart", "trust_calibration"};
}

absl::Status SetLiveOption(absl::string_view key, absl::string_view value,
                           LiveSourceOptions& options) {
  if (key == "rig") {
    if (value.empty()) return BadLiveOption(key, value, "a file");
    options.rig = std::string(value);
  } else if (key == "register") {
    ASSIGN_OR_RETURN(options.registers, ParseFlag(key, value));
  } else if (key == "restart") {
    ASSIGN_OR_RETURN(options.restarts, ParseFlag(key, value));
  } else if (key == "trust_calibration") {
    ASSIGN_OR_RETURN(options.trust_calibration, ParseFlag(key, value));
  } else if (key != "pair_within_ms") {
    return BadLiveOption(key, value, "another name");
  } else if (!absl::SimpleAtod(value, &options.pair_within_ms) || options.pair_within_ms < 0 ||
             options.pair_within_ms > kMostWithin_ms) {
    return BadLiveOption(key, value, absl::StrCat("a number from 0 to ", kMostWithin_ms));
  }
  return absl::OkStatus();
}

std::vector<std::pair<std::string, std::string>> FormatLiveOptions(
    const LiveSourceOptions& options) {
  std::vector<std::pair<std::string, std::string>> formatted;
  if (!options.rig.empty()) formatted.emplace_back("rig", options.rig);
  if (options.pair_within_ms != LiveSourceOptions().pair_within_ms) {
    formatted.emplace_back("pair_within_ms", FormatReal(options.pair_within_ms));
  }
  for (const auto& [key, flag] :
       {std::pair("register", options.registers), {"restart", options.restarts}}) {
    if (flag.has_value()) formatted.emplace_back(key, *flag ? "1" : "0");
  }
  if (options.trust_calibration) formatted.emplace_back("trust_calibration", "1");
  return formatted;
}

absl::StatusOr<Rig> ReadLiveRig(absl::string_view kind, const LiveSourceOptions& options) {
  if (options.rig.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        kind, ": a live camera needs its rig: --rig FILE (docs/rig.md says how to make one)"));
  }
  ASSIGN_OR_RETURN(Rig rig, ReadRigFile(options.rig));
  ASSIGN_OR_RETURN(const SourceFindings findings,
                   JudgeRig(rig, options.rig, options.trust_calibration));
  for (const SourceFinding& finding : findings) LOG(WARNING) << finding.text;
  return rig;
}

LiveOptions StreamOptions(const std::string& name, const LiveSourceOptions& options) {
  return {name, static_cast<int64_t>(1e6 * options.pair_within_ms), options.registers};
}

}  // namespace corbslam::client_agent
