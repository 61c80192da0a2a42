#include "client_agent/source/calibration/rgbd_calibration_file.h"

#include <map>
#include <set>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "client_agent/source/calibration/yaml_fields.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

using Fields = std::map<std::string, double>;

constexpr absl::string_view kNeeded[] = {"fx", "fy", "cx", "cy"};
constexpr absl::string_view kKnown[] = {
    "fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "depth_units_per_m", "width", "height"};

absl::StatusOr<Fields> ReadFields(const std::string& path, const YAML::Node& file) {
  Fields fields;
  for (const auto& entry : file) {
    const std::string key = entry.first.Scalar();
    if (std::find(std::begin(kKnown), std::end(kKnown), key) == std::end(kKnown)) {
      return LineError(
          path, LineOf(entry.first),
          absl::StrCat("unknown field ", key, ": known are ", absl::StrJoin(kKnown, ", ")));
    }
    if (!ReadFinite(entry.second, fields[key])) {
      return LineError(path, LineOf(entry.first), absl::StrCat(key, " is no finite number"));
    }
  }
  for (const absl::string_view needed : kNeeded) {
    if (!fields.contains(std::string(needed))) {
      return absl::InvalidArgumentError(absl::StrCat(path, ": ", needed, " is missing"));
    }
  }
  return fields;
}

double ValueOr0(const Fields& fields, const char* key) {
  const auto found = fields.find(key);
  return found == fields.end() ? 0 : found->second;
}

std::optional<double> Optional(const Fields& fields, const char* key) {
  const auto found = fields.find(key);
  return found == fields.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace

absl::StatusOr<RgbdCalibrationFile> ReadRgbdYaml(const std::string& path) {
  Fields fields;
  RETURN_IF_ERROR(UseYamlFields(path, [&](const YAML::Node& file) -> absl::Status {
    ASSIGN_OR_RETURN(fields, ReadFields(path, file));
    return absl::OkStatus();
  }));
  RgbdCalibrationFile read;
  read.fx_px = fields["fx"];
  read.fy_px = fields["fy"];
  read.cx_px = fields["cx"];
  read.cy_px = fields["cy"];
  read.distortion = {ValueOr0(fields, "k1"), ValueOr0(fields, "k2"), ValueOr0(fields, "p1"),
                     ValueOr0(fields, "p2"), ValueOr0(fields, "k3")};
  read.depth_units_per_m = Optional(fields, "depth_units_per_m");
  read.width_px = Optional(fields, "width");
  read.height_px = Optional(fields, "height");
  return read;
}

absl::StatusOr<RgbdCalibrationFile> ReadRgbdText(const std::string& path) {
  std::optional<RgbdCalibrationFile> read;
  RETURN_IF_ERROR(ForEachLine(path, [&](int line, absl::string_view text) -> absl::Status {
    const std::vector<absl::string_view> fields =
        absl::StrSplit(text, absl::ByAnyChar(" \t"), absl::SkipEmpty());
    if (read.has_value()) return LineError(path, line, "a second calibration");
    if (fields.size() != 4) {
      return LineError(path, line, absl::StrCat(fields.size(), " numbers instead of fx fy cx cy"));
    }
    ASSIGN_OR_RETURN(const std::vector<double> k, ParseNumbers(fields, path, line));
    read = RgbdCalibrationFile{k[0], k[1], k[2], k[3], {}, {}, {}, {}};
    return absl::OkStatus();
  }));
  if (!read.has_value()) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": no line with fx fy cx cy"));
  }
  return *read;
}

absl::StatusOr<RgbdCalibrationFile> ReadRgbdFile(const std::string& path) {
  return absl::EndsWith(path, ".txt") ? ReadRgbdText(path) : ReadRgbdYaml(path);
}

}  // namespace corbslam::client_agent
