#include "client_agent/source/calibration/kitti_calibration.h"

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "client_agent/source/calibration/plausibility.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

// Depth from this many baselines on is too coarse to make a point from one view.
constexpr double kCloseDepth_baselines = 35;
// Difference that rounding in a file may make.
constexpr double kSame_px = 0.01;

// A row P = K [I | t] of the file: fx 0 cx fx*tx, 0 fy cy ., 0 0 1 .
struct Projection {
  int line = 0;
  double fx_px = 0;
  double fy_px = 0;
  double cx_px = 0;
  double cy_px = 0;
  double shift_px_m = 0;  // fx times the camera's way along -x.
};

absl::StatusOr<Projection> ParseProjection(const std::string& path, int line,
                                           absl::string_view name, absl::string_view text) {
  const std::vector<absl::string_view> fields =
      absl::StrSplit(text, absl::ByAnyChar(" \t"), absl::SkipEmpty());
  if (fields.size() != 12) {
    return LineError(path, line,
                     absl::StrCat(name, " has ", fields.size(), " numbers instead of 12"));
  }
  ASSIGN_OR_RETURN(const std::vector<double> p, ParseNumbers(fields, path, line));
  constexpr double kZero = 1e-6;
  if (std::abs(p[1]) > kZero || std::abs(p[4]) > kZero || std::abs(p[8]) > kZero ||
      std::abs(p[9]) > kZero || std::abs(p[10] - 1) > kZero) {
    return LineError(path, line,
                     absl::StrCat(name,
                                  " is no projection of a rectified camera, which has the "
                                  "form fx 0 cx . 0 fy cy . 0 0 1 ."));
  }
  return Projection{line, p[0], p[5], p[2], p[6], p[3]};
}

struct Pair {
  Projection left;
  Projection right;
};

absl::StatusOr<Pair> ReadPair(const KittiCalibrationQuery& query) {
  std::map<std::string, Projection> rows;
  RETURN_IF_ERROR(ForEachLine(query.path, [&](int line, absl::string_view text) -> absl::Status {
    const std::pair<absl::string_view, absl::string_view> parts =
        absl::StrSplit(text, absl::MaxSplits(':', 1));
    const std::string name(absl::StripAsciiWhitespace(parts.first));
    if (name != query.left_row && name != query.right_row) return absl::OkStatus();
    if (rows.contains(name)) {
      return LineError(query.path, line,
                       absl::StrCat(name, " is in line ", rows.at(name).line, " too"));
    }
    ASSIGN_OR_RETURN(rows[name], ParseProjection(query.path, line, name, parts.second));
    return absl::OkStatus();
  }));
  for (const std::string& name : {query.left_row, query.right_row}) {
    if (!rows.contains(name)) {
      return absl::InvalidArgumentError(absl::StrCat(query.path, ": no line ", name));
    }
  }
  return Pair{rows.at(query.left_row), rows.at(query.right_row)};
}

// Checks that the pair is rectified: it has one focal length and one principal row, while its
// principal columns may differ.
absl::Status CheckIsPair(const KittiCalibrationQuery& query, const Pair& pair) {
  const std::tuple<const char*, double, double> same[] = {
      {"fx", pair.left.fx_px, pair.right.fx_px},
      {"fy", pair.left.fy_px, pair.right.fy_px},
      {"cy", pair.left.cy_px, pair.right.cy_px}};
  for (const auto& [field, left, right] : same) {
    if (std::abs(left - right) <= kSame_px) continue;
    return LineError(query.path, pair.right.line,
                     absl::StrCat(query.right_row, " has ", field, " ", right, ", ", query.left_row,
                                  " has ", left, ": a rectified pair has the same, is it one?"));
  }
  return absl::OkStatus();
}

absl::Status CheckBaselineSign(const KittiCalibrationQuery& query, const Pair& pair,
                               double baseline_m) {
  if (baseline_m > 0) return absl::OkStatus();
  return LineError(
      query.path, pair.right.line,
      absl::StrCat("the baseline from ", query.left_row, " to ", query.right_row, " is ",
                   baseline_m, " m, must be above 0: are left and right exchanged?"));
}

Camera MakeCamera(const KittiCalibrationQuery& query, const Pair& pair) {
  Camera camera;
  camera.fx_px = pair.left.fx_px;
  camera.fy_px = pair.left.fy_px;
  camera.cx_px = pair.left.cx_px;
  camera.cy_px = pair.left.cy_px;
  camera.width_px = query.width_px;
  camera.height_px = query.height_px;
  camera.baseline_m = (pair.left.shift_px_m - pair.right.shift_px_m) / pair.right.fx_px;
  camera.close_depth_m = kCloseDepth_baselines * camera.baseline_m;
  return camera;
}

absl::StatusOr<SourceFindings> CheckPlausible(const KittiCalibrationQuery& query,
                                              const Camera& camera, double right_cx_px) {
  Intrinsics intrinsics{camera.fx_px, camera.fy_px,    camera.cx_px,
                        camera.cy_px, camera.width_px, camera.height_px};
  ASSIGN_OR_RETURN(
      SourceFindings findings,
      CheckIntrinsics(intrinsics, absl::StrCat(query.path, ": ", query.left_row), query.trust));
  ASSIGN_OR_RETURN(const SourceFindings of_baseline,
                   CheckBaseline(camera.baseline_m, query.path, query.trust));
  findings.insert(findings.end(), of_baseline.begin(), of_baseline.end());
  if (std::abs(right_cx_px - camera.cx_px) <= kSame_px) return findings;
  intrinsics.cx_px = right_cx_px;
  ASSIGN_OR_RETURN(
      const SourceFindings of_right,
      CheckIntrinsics(intrinsics, absl::StrCat(query.path, ": ", query.right_row), query.trust));
  findings.insert(findings.end(), of_right.begin(), of_right.end());
  return findings;
}

}  // namespace

absl::StatusOr<FoundKittiCalibration> ReadKittiCalibration(const KittiCalibrationQuery& query) {
  ASSIGN_OR_RETURN(const Pair pair, ReadPair(query));
  RETURN_IF_ERROR(CheckIsPair(query, pair));
  FoundKittiCalibration found;
  const Camera camera = MakeCamera(query, pair);
  if (std::isfinite(camera.baseline_m)) {
    RETURN_IF_ERROR(CheckBaselineSign(query, pair, camera.baseline_m));
  }
  if (const absl::Status status = Validate(camera); !status.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(query.path, ": ", status.message()));
  }
  ASSIGN_OR_RETURN(found.findings, CheckPlausible(query, camera, pair.right.cx_px));
  found.calibration.camera = camera;
  found.calibration.right_cx_offset_px = pair.right.cx_px - camera.cx_px;
  return found;
}

}  // namespace corbslam::client_agent
