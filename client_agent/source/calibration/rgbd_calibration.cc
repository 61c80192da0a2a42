#include "client_agent/source/calibration/rgbd_calibration.h"

#include <filesystem>
#include <fstream>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "client_agent/source/calibration/named_cameras.h"
#include "client_agent/source/calibration/plausibility.h"
#include "client_agent/source/calibration/rgbd_calibration_file.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

namespace fs = std::filesystem;

constexpr double kVirtualBaseline_m = 0.08;
constexpr double kCloseDepth_m = 40 * kVirtualBaseline_m;
// The TUM format's own unit, where a calibration file leaves it out.
constexpr double kTumDepthUnits = 5000;

RgbdCalibration MakeCalibration(double fx_px, double fy_px, double cx_px, double cy_px,
                                const RgbdCalibrationQuery& query) {
  RgbdCalibration calibration;
  calibration.camera = {
      fx_px,        fy_px, cx_px, cy_px, query.width_px, query.height_px, kVirtualBaseline_m,
      kCloseDepth_m};
  return calibration;
}

absl::Status OtherSize(absl::string_view from, double width_px, double height_px,
                       const RgbdCalibrationQuery& query) {
  return absl::InvalidArgumentError(absl::StrCat(
      from, ": these intrinsics are of ", width_px, "x", height_px, " pictures, ",
      query.first_picture, " has ", query.width_px, "x", query.height_px,
      ": give a calibration of this size (DIR/calibration.yaml or ?calibration=FILE)"));
}

absl::StatusOr<FoundRgbdCalibration> FromFile(const std::string& path,
                                              const RgbdCalibrationQuery& query) {
  ASSIGN_OR_RETURN(const RgbdCalibrationFile file, ReadRgbdFile(path));
  const double width_px = file.width_px.value_or(query.width_px);
  const double height_px = file.height_px.value_or(query.height_px);
  if (width_px != query.width_px || height_px != query.height_px) {
    return OtherSize(path, width_px, height_px, query);
  }
  FoundRgbdCalibration found;
  found.calibration = MakeCalibration(file.fx_px, file.fy_px, file.cx_px, file.cy_px, query);
  found.calibration.lens = file.distortion;
  found.calibration.depth_units_per_m = file.depth_units_per_m.value_or(kTumDepthUnits);
  found.from = path;
  found.depth_units_from =
      file.depth_units_per_m.has_value() ? path : "the TUM format, as no file says otherwise";
  return found;
}

absl::StatusOr<FoundRgbdCalibration> FromNamed(const NamedCamera& camera, std::string from,
                                               const RgbdCalibrationQuery& query) {
  if (query.width_px != kNamedCameraWidth_px || query.height_px != kNamedCameraHeight_px) {
    return OtherSize(from, kNamedCameraWidth_px, kNamedCameraHeight_px, query);
  }
  FoundRgbdCalibration found;
  found.calibration =
      MakeCalibration(camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px, query);
  found.calibration.lens = camera.distortion;
  found.calibration.depth_units_per_m = camera.depth_units_per_m;
  found.depth_units_from = from;
  found.from = std::move(from);
  return found;
}

// Returns the recording that a file's opening comments say it is of: "# file: 'NAME.bag'". Empty:
// none.
std::string RecordingOf(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  while (std::getline(file, line)) {
    absl::string_view rest = absl::StripAsciiWhitespace(line);
    if (!absl::ConsumePrefix(&rest, "#")) return "";
    rest = absl::StripLeadingAsciiWhitespace(rest);
    if (!absl::ConsumePrefix(&rest, "file:")) continue;
    rest = absl::StripAsciiWhitespace(rest);
    absl::ConsumePrefix(&rest, "'");
    absl::ConsumeSuffix(&rest, "'");
    return std::string(absl::StripSuffix(rest, ".bag"));
  }
  return "";
}

struct NamedBy {
  const NamedCamera* camera = nullptr;
  std::string by;  // How it is named, for messages.
};

// Returns INVALID_ARGUMENT where two files name different cameras.
absl::StatusOr<NamedBy> FindNaming(const std::string& folder) {
  NamedBy named;
  for (const char* name : {"rgb.txt", "depth.txt", "groundtruth.txt"}) {
    const std::string list = absl::StrCat(folder, "/", name);
    const std::string recording = RecordingOf(list);
    const NamedCamera* camera = CameraOfTumRecording(recording);
    if (camera == nullptr) continue;
    const std::string by = absl::StrCat(list, " says that it is of ", recording);
    if (named.camera != nullptr && named.camera != camera) {
      return absl::InvalidArgumentError(absl::StrCat(
          named.by, ", but ", by, ": say which camera it is by ?camera=", named.camera->name,
          " or ?camera=", camera->name));
    }
    named = {camera, by};
  }
  if (named.camera != nullptr) return named;
  std::error_code error;
  const std::string name = fs::canonical(folder, error).filename().string();
  return NamedBy{error ? nullptr : CameraOfTumRecording(name),
                 absl::StrCat("the folder is called ", name)};
}

absl::Status NoCalibration(const RgbdCalibrationQuery& query) {
  return absl::NotFoundError(absl::StrCat(
      query.folders.front(),
      ": no calibration. Put calibration.yaml there (lines fx: fy: cx: cy: in pixels; k1 k2 p1 p2 "
      "k3 where the pictures are distorted; depth_units_per_m), or ETH3D's calibration.txt, or say "
      "?calibration=FILE, or ?camera=NAME for one of ",
      ListNamedCameras()));
}

// Returns nullopt where nothing in the folder says which camera it is.
absl::StatusOr<std::optional<FoundRgbdCalibration>> FromFolder(const std::string& folder,
                                                               const RgbdCalibrationQuery& query) {
  std::error_code ignored;
  for (const char* name : {"/calibration.yaml", "/calibration.txt"}) {
    if (fs::exists(folder + name, ignored)) return FromFile(folder + name, query);
  }
  ASSIGN_OR_RETURN(const NamedBy named, FindNaming(folder));
  if (named.camera == nullptr) return std::nullopt;
  return FromNamed(*named.camera,
                   absl::StrCat("the values published for ", named.camera->name, ", as ", named.by),
                   query);
}

absl::StatusOr<FoundRgbdCalibration> Find(const RgbdCalibrationQuery& query) {
  if (!query.file.empty()) return FromFile(query.file, query);
  if (!query.camera.empty()) {
    const NamedCamera* camera = FindNamedCamera(query.camera);
    if (camera != nullptr) {
      return FromNamed(*camera, absl::StrCat("?camera=", query.camera), query);
    }
    return absl::InvalidArgumentError(
        absl::StrCat("?camera=", query.camera, ": known are ", ListNamedCameras()));
  }
  for (const std::string& folder : query.folders) {
    ASSIGN_OR_RETURN(std::optional<FoundRgbdCalibration> found, FromFolder(folder, query));
    if (found.has_value()) return *std::move(found);
  }
  return NoCalibration(query);
}

}  // namespace

absl::StatusOr<FoundRgbdCalibration> FindRgbdCalibration(const RgbdCalibrationQuery& query) {
  ASSIGN_OR_RETURN(FoundRgbdCalibration found, Find(query));
  const Camera& camera = found.calibration.camera;
  const double units = found.calibration.depth_units_per_m;
  absl::Status possible = Validate(camera);
  possible.Update(Validate(found.calibration.lens));
  if (!(units > 0 && units <= 1e6)) {
    possible.Update(absl::InvalidArgumentError(
        absl::StrCat("depth_units_per_m ", units, ", must be above 0 and at most 1000000")));
  }
  if (!possible.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(found.from, ": ", possible.message()));
  }
  ASSIGN_OR_RETURN(found.findings,
                   CheckIntrinsics({camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px,
                                    camera.width_px, camera.height_px},
                                   found.from, query.trust));
  return found;
}

}  // namespace corbslam::client_agent
