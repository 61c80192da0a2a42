#include "client_agent/source/bag/bag_options.h"

#include "absl/strings/str_cat.h"
#include "client_agent/source/option_values.h"
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

}  // namespace

std::vector<absl::string_view> BagOptionNames() {
  std::vector<absl::string_view> names;
  for (const TopicOption& option : kTopicOptions) names.push_back(option.name);
  for (const char* name : {"imu", "rig", "time", "scale", "trust_calibration", "pair_within_ms",
                           "depth_units", "register"}) {
    names.emplace_back(name);
  }
  return names;
}

absl::Status ApplyBagOption(absl::string_view key, absl::string_view value, BagOptions& options) {
  for (const TopicOption& option : kTopicOptions) {
    if (key != option.name) continue;
    if (value.empty()) return BadOption(key, value, "a topic");
    options.*option.topic = absl::StrCat(value[0] == '/' ? "" : "/", value);
    return absl::OkStatus();
  }
  if (key == "imu") {
    if (value.empty() || value == "1") return BadOption(key, value, "a topic, or 0 for none");
    options.imu = value == "0" ? "0" : absl::StrCat(value[0] == '/' ? "" : "/", value);
    return absl::OkStatus();
  }
  if (key == "rig") {
    if (value.empty()) return BadOption(key, value, "a file");
    options.rig_file = std::string(value);
    return absl::OkStatus();
  }
  if (key == "time") {
    if (value != "header" && value != "recording") {
      return BadOption(key, value, "header or recording");
    }
    options.by_recording_time = value == "recording";
    return absl::OkStatus();
  }
  if (key == "scale") return ParseReal(key, value, 0.1, 1, options.scale);
  if (key == "trust_calibration") return ParseFlag(key, value, options.trust_calibration);
  if (key == "register") return ParseFlag(key, value, options.registers.emplace());
  if (key == "pair_within_ms") {
    return ParseReal(key, value, 0, 1000, options.pair_within_ms.emplace());
  }
  if (key == "depth_units") {
    return ParseReal(key, value, 1, 1e6, options.depth_units_per_m.emplace());
  }
  return BadOption(key, value, "another name");
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
  if (!options.imu.empty()) formatted.emplace_back("imu", options.imu);
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
