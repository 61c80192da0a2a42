#include "client_agent/ros2/ros2_arguments.h"

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr absl::string_view kAssigns = ":=";

absl::StatusOr<Ros2Rule> ParseRule(absl::string_view flag, absl::string_view text) {
  const size_t assigns = text.find(kAssigns);
  if (assigns == absl::string_view::npos || assigns == 0 ||
      (flag == "-r" && assigns + kAssigns.size() == text.size())) {
    return absl::InvalidArgumentError(
        absl::StrCat("--ros-args ", flag, " ", text, ": wants FROM:=TO, without spaces"));
  }
  Ros2Rule rule;
  absl::string_view from = text.substr(0, assigns);
  if (const size_t node = from.find(':'); node != absl::string_view::npos) {
    rule.node = std::string(from.substr(0, node));
    from.remove_prefix(node + 1);
  }
  rule.from = std::string(from);
  rule.to = std::string(text.substr(assigns + kAssigns.size()));
  return rule;
}

// Flags of rcl that say how ROS 2 logs.
bool IsOfLogging(absl::string_view flag) {
  return absl::EndsWith(flag, "-stdout-logs") || absl::EndsWith(flag, "-rosout-logs") ||
         absl::EndsWith(flag, "-external-lib-logs");
}

// Takes the flag at `at`, and its value, which then is the last that was taken.
absl::Status TakeRosFlag(const std::vector<std::string>& arguments, size_t& at,
                         Ros2Arguments& parsed) {
  const std::string& flag = arguments[at];
  if (IsOfLogging(flag)) {
    parsed.without_effect.push_back(flag);
    return absl::OkStatus();
  }
  const bool is_remap = flag == "-r" || flag == "--remap";
  const bool is_parameter = flag == "-p" || flag == "--param";
  const bool is_logging = flag == "--log-level" || flag == "--log-config-file";
  if (!is_remap && !is_parameter && !is_logging && flag != "--params-file") {
    return absl::InvalidArgumentError(absl::StrCat(
        "--ros-args ", flag,
        ": known are -r FROM:=TO, -p NAME:=VALUE, --params-file FILE and ROS 2's flags "
        "of logging; the program's own flags go before --ros-args, or behind --"));
  }
  if (++at == arguments.size()) {
    return absl::InvalidArgumentError(absl::StrCat("--ros-args ", flag, ": its value is missing"));
  }
  const std::string& value = arguments[at];
  if (is_logging) {
    parsed.without_effect.push_back(absl::StrCat(flag, " ", value));
  } else if (is_remap) {
    ASSIGN_OR_RETURN(Ros2Rule rule, ParseRule("-r", value));
    parsed.remaps.push_back(std::move(rule));
  } else if (is_parameter) {
    ASSIGN_OR_RETURN(Ros2Rule rule, ParseRule("-p", value));
    parsed.parameters.push_back(std::move(rule));
  } else {
    parsed.parameter_files.push_back(value);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Ros2Arguments> ParseRos2Arguments(const std::vector<std::string>& arguments) {
  Ros2Arguments parsed;
  bool is_ros = false;
  for (size_t at = 0; at < arguments.size(); ++at) {
    if (arguments[at] == "--ros-args") {
      is_ros = true;
    } else if (!is_ros) {
      parsed.others.push_back(arguments[at]);
    } else if (arguments[at] == "--") {
      is_ros = false;
    } else {
      RETURN_IF_ERROR(TakeRosFlag(arguments, at, parsed));
    }
  }
  return parsed;
}

}  // namespace corbslam::client_agent
