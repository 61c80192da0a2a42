#include "client_agent/source/tum_calibration.h"

#include <cmath>
#include <filesystem>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam {
namespace {

constexpr double kVirtualBaseline_m = 0.08;
constexpr double kCloseDepth_m = 40 * kVirtualBaseline_m;

struct Values {
  double fx, fy, cx, cy;
  RadialTangential distortion;
};

// As published with the recordings, of their colour cameras.
constexpr Values kFreiburg1 = {517.306408,
                               516.469215,
                               318.643040,
                               255.313989,
                               {0.262383, -0.953104, -0.005358, 0.002628, 1.163314}};
constexpr Values kFreiburg2 = {520.908620,
                               521.007327,
                               325.141442,
                               249.701764,
                               {0.231222, -0.784899, -0.003257, -0.000105, 0.917205}};
constexpr Values kFreiburg3 = {535.4, 539.2, 320.1, 247.6, {}};

Values ChooseByName(const std::string& directory) {
  const std::string name = std::filesystem::path(directory).filename().string();
  if (absl::StrContains(name, "freiburg2") || absl::StrContains(name, "fr2")) return kFreiburg2;
  if (absl::StrContains(name, "freiburg3") || absl::StrContains(name, "fr3")) return kFreiburg3;
  return kFreiburg1;
}

double* FindField(absl::string_view key, RgbdCalibration& calibration) {
  Camera& camera = calibration.camera;
  RadialTangential& distortion = calibration.distortion;
  const std::pair<absl::string_view, double*> fields[] = {
      {"fx", &camera.fx_px},  {"fy", &camera.fy_px},
      {"cx", &camera.cx_px},  {"cy", &camera.cy_px},
      {"k1", &distortion.k1}, {"k2", &distortion.k2},
      {"p1", &distortion.p1}, {"p2", &distortion.p2},
      {"k3", &distortion.k3}, {"depth_units_per_m", &calibration.depth_units_per_m}};
  for (const auto& [name, field] : fields) {
    if (name == key) return field;
  }
  return nullptr;
}

absl::Status ReadFile(const std::string& path, RgbdCalibration& calibration) {
  calibration.distortion = {};
  return ForEachLine(path, [&](int line, absl::string_view text) -> absl::Status {
    const std::pair<absl::string_view, absl::string_view> parts =
        absl::StrSplit(text, absl::MaxSplits(':', 1));
    double* field = FindField(absl::StripAsciiWhitespace(parts.first), calibration);
    if (field == nullptr) return LineError(path, line, absl::StrCat("unknown field ", parts.first));
    if (!absl::SimpleAtod(absl::StripAsciiWhitespace(parts.second), field)) {
      return LineError(path, line, absl::StrCat(parts.first, " is no number: ", parts.second));
    }
    return absl::OkStatus();
  });
}

}  // namespace

absl::StatusOr<RgbdCalibration> ReadTumCalibration(const std::string& directory, int width_px,
                                                   int height_px) {
  const Values values = ChooseByName(directory);
  RgbdCalibration calibration;
  calibration.camera = {values.fx, values.fy, values.cx,          values.cy,
                        width_px,  height_px, kVirtualBaseline_m, kCloseDepth_m};
  calibration.distortion = values.distortion;
  const std::string path = directory + "/calibration.yaml";
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored)) RETURN_IF_ERROR(ReadFile(path, calibration));
  for (const absl::Status& status :
       {Validate(calibration.camera), Validate(calibration.distortion)}) {
    if (!status.ok()) {
      return absl::InvalidArgumentError(absl::StrCat(path, ": ", status.message()));
    }
  }
  if (!(calibration.depth_units_per_m > 0 && std::isfinite(calibration.depth_units_per_m))) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": depth_units_per_m ", calibration.depth_units_per_m));
  }
  return calibration;
}

}  // namespace corbslam
