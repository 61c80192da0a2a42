#include "client_agent/source/opening_options.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "client_agent/source/calibration/named_cameras.h"
#include "client_agent/source/option_values.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
std::vector<absl::string_view> OpeningOptionNames(SourceLayout layout) {
  switch (layout) {
    case SourceLayout::kKitti:
      return {"rig", "scale", "trust_calibration", "fps", "images", "imu"};
    case SourceLayout::kEuroc:
      return {"rig", "scale", "trust_calibration", "pair_within_ms", "imu"};
    case SourceLayout::kTum:
      return {"rig", "scale", "camera", "calibration", "trust_calibration", "register", "imu"};
    case SourceLayout::kSevenScenes:
      return {"rig",      "scale", "camera", "calibration", "trust_calibration",
              "register", "fps",   "imu"};
    case SourceLayout::kRegistered:
      break;
  }
  return {};
}

bool IsOpeningOption(SourceLayout layout, absl::string_view key) {
  const std::vector<absl::string_view> names = OpeningOptionNames(layout);
  return std::find(names.begin(), names.end(), key) != names.end();
}

absl::Status ApplyOpeningOption(absl::string_view key, absl::string_view value,
                                SourceOpening& opening) {
  if (key == "camera") {
    if (FindNamedCamera(value) == nullptr) {
      return BadOption(key, value, absl::StrCat("one of ", ListNamedCameras()));
    }
    opening.camera = std::string(value);
  } else if (key == "rig") {
    if (value.empty()) return BadOption(key, value, "a file");
    opening.rig_file = std::string(value);
  } else if (key == "scale") {
    return ParseReal(key, value, 0.1, 1, opening.scale);
  } else if (key == "calibration") {
    if (value.empty()) return BadOption(key, value, "a file");
    opening.calibration_file = std::string(value);
  } else if (key == "trust_calibration") {
    return ParseFlag(key, value, opening.trust_calibration);
  } else if (key == "register") {
    return ParseFlag(key, value, opening.registers.emplace());
  } else if (key == "fps") {
    return ParseReal(key, value, 0.1, 1000, opening.fps.emplace());
  } else if (key == "images") {
    if (value != "grey" && value != "colour") return BadOption(key, value, "grey or colour");
    opening.images = std::string(value);
  } else if (key == "pair_within_ms") {
    return ParseReal(key, value, 0, 1000, opening.pair_within_ms);
  } else if (key == "imu") {
    if (value.empty() || value == "1") return BadOption(key, value, "a file, or 0 for none");
    opening.imu = std::string(value);
  } else {
    return BadOption(key, value, "another name");
  }
  return absl::OkStatus();
}

std::vector<std::pair<std::string, std::string>> FormatOpening(const SourceOpening& opening) {
  std::vector<std::pair<std::string, std::string>> options;
  const auto add_word = [&](const char* key, const std::string& value) {
    if (!value.empty()) options.push_back({key, value});
  };
  const SourceOpening plain;
  add_word("rig", opening.rig_file);
  if (opening.scale != plain.scale) add_word("scale", FormatReal(opening.scale));
  add_word("camera", opening.camera);
  add_word("calibration", opening.calibration_file);
  if (opening.trust_calibration) add_word("trust_calibration", "1");
  if (opening.registers.has_value()) add_word("register", *opening.registers ? "1" : "0");
  if (opening.fps.has_value()) add_word("fps", FormatReal(*opening.fps));
  add_word("images", opening.images);
  if (opening.pair_within_ms != plain.pair_within_ms) {
    add_word("pair_within_ms", FormatReal(opening.pair_within_ms));
  }
  add_word("imu", opening.imu);
  return options;
}

}  // namespace corbslam::client_agent
