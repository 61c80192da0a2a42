#include "client_agent/source/bag/bag_options.h"

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

struct TopicOption {
  absl::string_view name;
  std::string BagOptions::*topic;
};
constexpr TopicOption kTopicOptions[] = {{"left", &BagOptions::left},
                                         {"right", &BagOptions::right},
                                         {"depth", &BagOptions::depth},
                                         {"left_info", &BagOptions::left_info},
                                         {"right_info", &BagOptions::right_info},
                                         {"depth_info", &BagOptions::depth_info}};

absl::Status BadBagOption(absl::string_view key, absl::string_view value,
                          absl::string_view wanted) {
  return absl::InvalidArgumentError(
      absl::StrCat("source option ", key, "=", value, ": wants ", wanted));
}

absl::Status ParseBagReal(absl::string_view key, absl::string_view value, double least, double most,
                          double& number) {
  if (absl::SimpleAtod(value, &number) && number >= least && number <= most) {
    return absl::OkStatus();
  }
  return BadBagOption(key, value, absl::StrCat("a number from ", least, " to ", most));
}

absl::Status ParseBagFlag(absl::string_view key, absl::string_view value, bool& flag) {
  if (value != "" && value != "0" && value != "1") return BadBagOption(key, value, "0 or 1");
  flag = value != "0";
  return absl::OkStatus();
}

}  // namespace

std::vector<absl::string_view> BagOptionNames() {
  std::vector<absl::string_view> names;
  for (const TopicOption& option : kTopicOptions) names.push_back(option.name);
  for (const char* name :
       {"rig", "time", "scale", "trust_calibration", "pair_within_ms", "depth_units", "register"}) {
    names.emplace_back(name);
  }
  return names;
}

absl::Status ApplyBagOption(absl::string_view key, absl::string_view value, BagOptions& options) {
  for (const TopicOption& option : kTopicOptions) {
    if (key != option.name) continue;
    if (value.empty()) return BadBagOption(key, value, "a topic");
    options.*option.topic = absl::StrCat(value[0] == '/' ? "" : "/", value);
    return absl::OkStatus();
  }
  if (key == "rig") {
    if (value.empty()) return BadBagOption(key, value, "a file");
    options.rig_file = std::string(value);
    return absl::OkStatus();
  }
  if (key == "time") {
    if (value != "header" && value != "recording") {
      return BadBagOption(key, value, "header or recording");
    }
    options.by_recording_time = value == "recording";
    return absl::OkStatus();
  }
  if (key == "scale") return ParseBagReal(key, value, 0.1, 1, options.scale);
  if (key == "trust_calibration") return ParseBagFlag(key, value, options.trust_calibration);
  if (key == "register") return ParseBagFlag(key, value, options.registers.emplace());
  if (key == "pair_within_ms") {
    return ParseBagReal(key, value, 0, 1000, options.pair_within_ms.emplace());
  }
  if (key == "depth_units") {
    return ParseBagReal(key, value, 1, 1e6, options.depth_units_per_m.emplace());
  }
  return BadBagOption(key, value, "another name");
}

absl::Status Validate(const BagOptions& options) {
  if (!options.right.empty() && !options.depth.empty()) {
    return absl::InvalidArgumentError(
        "source options right and depth: a stereo pair is left and right, an RGB-D camera left "
        "and depth");
  }
  return absl::OkStatus();
}

std::vector<std::pair<std::string, std::string>> FormatBagOptions(const BagOptions& options) {
  std::vector<std::pair<std::string, std::string>> formatted;
  for (const TopicOption& option : kTopicOptions) {
    const std::string& topic = options.*option.topic;
    if (!topic.empty()) formatted.emplace_back(option.name, topic);
  }
  const BagOptions plain;
  if (!options.rig_file.empty()) formatted.emplace_back("rig", options.rig_file);
  if (options.by_recording_time) formatted.emplace_back("time", "recording");
  if (options.scale != plain.scale) formatted.emplace_back("scale", FormatReal(options.scale));
  if (options.trust_calibration) formatted.emplace_back("trust_calibration", "1");
  if (options.pair_within_ms.has_value()) {
    formatted.emplace_back("pair_within_ms", FormatReal(*options.pair_within_ms));
  }
  if (options.depth_units_per_m.has_value()) {
    formatted.emplace_back("depth_units", FormatReal(*options.depth_units_per_m));
  }
  if (options.registers.has_value()) {
    formatted.emplace_back("register", *options.registers ? "1" : "0");
  }
  return formatted;
}

}  // namespace corbslam::client_agent
