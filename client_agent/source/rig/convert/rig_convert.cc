#include "client_agent/source/rig/convert/rig_convert.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "client_agent/source/calibration/yaml_fields.h"
#include "client_agent/source/rig/convert/rig_readers.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

// Of the focal length: less is rounding.
constexpr double kMostSkew = 1e-6;

struct Format {
  absl::string_view name;
  // Names of fields, each of which is in no file but of this format. Of LIST/FIELD the first entry
  // of a list has the field, or the map of that name.
  std::vector<std::string> fields;
  absl::StatusOr<ConvertedRig> (*read)(const RigFiles& files);
};

const std::vector<Format>& Formats() {
  static const auto* const formats = new std::vector<Format>{
      {"kalibr", {"cam0", "imu0", "update_rate"}, &ReadKalibr},
      {"ros", {"camera_matrix", "projection_matrix", "P", "p"}, &ReadRosPair},
      {"euroc", {"T_BS"}, &ReadEurocPair},
      {"orbslam", {"Camera.fx", "Camera1.fx", "LEFT.K"}, &ReadOrbSlam},
      {"opencv", {"M1", "K1", "cameraMatrix1", "R", "T"}, &ReadOpenCvStereo},
      {"kitti", {"P0", "P_rect_00"}, &ReadKittiPair},
      {"basalt", {"value0"}, &ReadBasalt},
      {"svo", {"cameras/camera"}, &ReadSvo},
      {"okvis2", {"cameras/T_SC"}, &ReadOkvis2},
      {"stella_vslam", {"Camera/setup"}, &ReadStellaVslam},
      {"vins_fusion", {"num_of_cam", "cam0_calib", "model_type"}, &ReadVinsFusion}};
  return *formats;
}

const Format* FindByFields(const std::function<bool(const std::string&)>& has) {
  for (const Format& format : Formats()) {
    if (std::any_of(format.fields.begin(), format.fields.end(), has)) return &format;
  }
  return nullptr;
}

// Returns the names at the beginnings of a text file's lines, up to a colon.
absl::StatusOr<const Format*> FindInText(const std::string& path) {
  std::vector<std::string> names;
  RETURN_IF_ERROR(ForEachLine(path, [&](int, absl::string_view text) {
    names.emplace_back(text.substr(0, text.find(':')));
    return absl::OkStatus();
  }));
  return FindByFields([&](const std::string& field) {
    return std::find(names.begin(), names.end(), field) != names.end();
  });
}

bool HasField(const YAML::Node& file, const std::string& field) {
  const size_t slash = field.find('/');
  if (slash == std::string::npos) return file[field].IsDefined();
  const YAML::Node within = file[field.substr(0, slash)];
  const std::string inner = field.substr(slash + 1);
  if (within.IsDefined() && within.IsMap()) return within[inner].IsDefined();
  return within.IsDefined() && within.IsSequence() && within.size() > 0 && within[0].IsMap() &&
         within[0][inner].IsDefined();
}

// Refuses the first file by its writer's name, where that is known and not read.
absl::Status CheckIsNotForeign(const std::string& path) {
  constexpr size_t kLooked = size_t{1} << 20;
  std::ifstream file(path, std::ios::binary);
  std::string begin(kLooked, '\0');
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<size_t>(std::max<std::streamsize>(0, file.gcount())));
  const std::string foreign = DescribeForeignCalibration(begin);
  if (foreign.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", foreign));
}

absl::StatusOr<const Format*> FindInYaml(const std::string& path) {
  const Format* found = nullptr;
  RETURN_IF_ERROR(UseYamlFields(path, [&](const YAML::Node& file) -> absl::Status {
    if (file["rig"].IsDefined()) {
      return absl::InvalidArgumentError(absl::StrCat(path, ": is a rig file already"));
    }
    found = FindByFields([&](const std::string& field) { return HasField(file, field); });
    return absl::OkStatus();
  }));
  return found;
}

absl::StatusOr<const Format*> FindFormat(const RigFiles& files) {
  if (!files.format.empty()) {
    for (const Format& format : Formats()) {
      if (format.name == files.format) return &format;
    }
    return absl::InvalidArgumentError(
        absl::StrCat("format '", files.format, "', known are ", absl::StrJoin(RigFormats(), ", ")));
  }
  const std::string& path = files.paths[0];
  std::error_code ignored;
  const std::filesystem::path as_path(path);
  const Format* found = nullptr;
  if (std::filesystem::is_directory(as_path, ignored)) {
    found = FindByFields([](const std::string& field) { return field == "T_BS"; });
  } else if (const absl::Status foreign = CheckIsNotForeign(path); !foreign.ok()) {
    return foreign;
  } else if (as_path.extension() == ".txt") {
    ASSIGN_OR_RETURN(found, FindInText(path));
  } else {
    ASSIGN_OR_RETURN(found, FindInYaml(path));
  }
  if (found != nullptr) return found;
  return absl::InvalidArgumentError(absl::StrCat(path, ": holds no calibration of a known format (",
                                                 absl::StrJoin(RigFormats(), ", "),
                                                 "), by the names of its fields; write a rig file "
                                                 "by hand (docs/rig.md)"));
}

// Notes what is improbable; refuses what can't be.
absl::Status CheckPlausible(const RigFiles& files, ConvertedRig& converted) {
  const absl::StatusOr<SourceFindings> findings =
      JudgeRig(converted.rig, absl::StrJoin(files.paths, ", "), files.trust);
  if (!findings.ok()) {
    // Sources have it as an option, the converter as a flag.
    return absl::Status(findings.status().code(),
                        absl::StrReplaceAll(findings.status().message(),
                                            {{"?trust-calibration", "--trust-calibration"}}));
  }
  for (const SourceFinding& finding : *findings) converted.notes.push_back(finding.text);
  return absl::OkStatus();
}

}  // namespace

namespace {

// Tools write 0 where nobody knows a number; and a clock that is another one's altogether is no
// matter of a rig.
void LeaveOutUnknown(ConvertedRig& converted) {
  std::optional<StatedImu>& imu = converted.rig.imu;
  if (!imu.has_value()) return;
  const std::pair<const char*, std::optional<double>&> numbers[] = {
      {"rate", imu->rate_hz},
      {"gyroscope's noise", imu->gyro_noise},
      {"accelerometer's noise", imu->accel_noise},
      {"gyroscope's walk", imu->gyro_walk},
      {"accelerometer's walk", imu->accel_walk}};
  for (const auto& [name, number] : numbers) {
    if (number != 0.0) continue;
    number.reset();
    converted.notes.push_back(absl::StrCat("the IMU's ", name, " is 0, which is left out"));
  }
  if (Validate(*imu).ok() || std::abs(imu->time_offset_s) <= kMostImuOffset_s) return;
  converted.notes.push_back(
      absl::StrCat("the IMU is left out: its clock and the camera's are ",
                   std::abs(imu->time_offset_s), " s apart, of which a rig states at most ",
                   kMostImuOffset_s, ": stamp both by one clock, and calibrate again"));
  imu.reset();
}

}  // namespace

std::vector<absl::string_view> RigFormats() {
  std::vector<absl::string_view> names;
  for (const Format& format : Formats()) names.push_back(format.name);
  return names;
}

absl::Status ExpectFiles(const RigFiles& files, size_t count, absl::string_view what) {
  if (files.paths.size() == count) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("given ", files.paths.size(), " files, wanted: ", what));
}

absl::StatusOr<ConvertedRig> ReadOneFile(
    const RigFiles& files, absl::string_view what,
    absl::FunctionRef<absl::Status(const YAML::Node& file, const std::string& path,
                                   ConvertedRig& converted)>
        read) {
  RETURN_IF_ERROR(ExpectFiles(files, 1, what));
  ConvertedRig converted;
  const std::string& path = files.paths[0];
  RETURN_IF_ERROR(
      UseYamlFields(path, [&](const YAML::Node& file) { return read(file, path, converted); }));
  return converted;
}

absl::Status CheckCameraMatrix(const std::vector<double>& k, const std::string& path,
                               absl::string_view field) {
  const double limit_px = kMostSkew * std::abs(k[0]);
  if (!(std::abs(k[1]) <= limit_px)) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": ", field, " has a skew of ", k[1],
                     " px, which a rig has no place for: calibrate without skew"));
  }
  if (k[3] == 0 && k[6] == 0 && k[7] == 0 && k[8] == 1) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(path, ": ", field, " is no camera matrix by its rows: fx 0 cx, 0 fy cy, 0 0 1"));
}

void UseOneCamera(absl::string_view what_says_so, const RigCamera& camera,
                  ConvertedRig& converted) {
  converted.rig.kind = RigKind::kMonocular;
  converted.rig.cameras = {camera};
  converted.notes.push_back(absl::StrCat(
      what_says_so, ": the rig is of one camera alone (kind: monocular), whose map has no metres"));
}

absl::StatusOr<PictureSize> NeedSize(const RigFiles& files) {
  if (files.size.has_value()) return *files.size;
  return absl::InvalidArgumentError(
      absl::StrCat(absl::StrJoin(files.paths, ", "),
                   ": does not say how large the pictures are: give --size, as --size 640x480"));
}

absl::StatusOr<ConvertedRig> ConvertRig(const RigFiles& files) {
  if (files.paths.empty()) return absl::InvalidArgumentError("no file of a calibration is given");
  ASSIGN_OR_RETURN(const Format* const format, FindFormat(files));
  if (!files.lens.empty() && format->read != &ReadOpenCvStereo) {
    return absl::InvalidArgumentError(
        absl::StrCat("--lens is of OpenCV's files, which don't say it; these are ", format->name));
  }
  ASSIGN_OR_RETURN(ConvertedRig converted, format->read(files));
  converted.format = std::string(format->name);
  LeaveOutUnknown(converted);
  RETURN_IF_ERROR(CheckPlausible(files, converted));
  const absl::Status possible = Validate(converted.rig);
  if (possible.ok()) return converted;
  return absl::InvalidArgumentError(
      absl::StrCat(absl::StrJoin(files.paths, ", "), ": ", possible.message()));
}

}  // namespace corbslam::client_agent
