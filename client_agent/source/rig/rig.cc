#include "client_agent/source/rig/rig.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client_agent/source/calibration/plausibility.h"
#include "client_agent/source/pictures/mask_picture.h"
#include "client_agent/source/rig/rig_depth.h"
#include "slam/camera/close_depth.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr double kMostBaseline_m = 20;
// More is another clock, or another unit.
constexpr double kMostTimeOffset_s = 0.5;
// Rectified cameras that differ by less are one.
constexpr double kSame_px = 0.01;

absl::Status CheckRange(absl::string_view field, double value, double above, double most) {
  if (value > above && value <= most) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(field, " is ", value, ", must be above ", above, " and at most ", most));
}

bool Distorts(const RawCamera& camera) {
  const auto* const pinhole = std::get_if<RadialTangential>(&camera.lens);
  return pinhole == nullptr || !pinhole->IsZero();
}

absl::Status ValidateRectified(const Rig& rig) {
  const RawCamera& left = rig.cameras[0].raw;
  const RawCamera& right = rig.cameras[1].raw;
  if (Distorts(left) || Distorts(right)) {
    return absl::InvalidArgumentError(
        "rectified pictures come through a lens that distorts: leave its numbers out, or say "
        "'rectified: false' where the pictures are as the cameras take them");
  }
  for (const auto& [field, a, b] : {std::tuple("focal_px's x", left.fx_px, right.fx_px),
                                    {"focal_px's y", left.fy_px, right.fy_px},
                                    {"principal_px's y", left.cy_px, right.cy_px}}) {
    if (std::abs(a - b) <= kSame_px) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(field, " is ", a, " of the left camera and ", b,
                     " of the right one: a rectified pair has the same, is it one?"));
  }
  if (rig.baseline_m > 0 && rig.baseline_m <= kMostBaseline_m) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("baseline_m is ", rig.baseline_m,
                                                 ", must be above 0 and at most ", kMostBaseline_m,
                                                 ": is it in metres?"));
}

Camera PinholeOf(const RigCamera& camera) {
  return {.fx_px = camera.raw.fx_px,
          .fy_px = camera.raw.fy_px,
          .cx_px = camera.raw.cx_px,
          .cy_px = camera.raw.cy_px,
          .width_px = camera.width_px,
          .height_px = camera.height_px};
}

RawStereo RawPairOf(const Rig& rig) {
  RawStereo pair;
  pair.left = rig.cameras[0].raw;
  pair.right = rig.cameras[1].raw;
  pair.right_from_left = rig.right_from_left;
  pair.width_px = rig.cameras[0].width_px;
  pair.height_px = rig.cameras[0].height_px;
  pair.widest_field_deg = rig.widest_field_deg;
  return pair;
}

absl::Status ValidateStereo(const Rig& rig) {
  if (rig.cameras.size() != 2) {
    return absl::InvalidArgumentError(
        absl::StrCat("a stereo pair has 2 cameras, given ", rig.cameras.size()));
  }
  const RigCamera& left = rig.cameras[0];
  const RigCamera& right = rig.cameras[1];
  if (left.width_px != right.width_px || left.height_px != right.height_px) {
    return absl::InvalidArgumentError(absl::StrCat("the left pictures have ", left.width_px, "x",
                                                   left.height_px, " pixels, the right ones ",
                                                   right.width_px, "x", right.height_px));
  }
  return rig.rectified ? ValidateRectified(rig) : Validate(RawPairOf(rig));
}

absl::Status ValidateRgbd(const Rig& rig) {
  if (rig.cameras.size() != 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("an RGB-D camera has 1 camera (and depth), given ", rig.cameras.size()));
  }
  RETURN_IF_ERROR(CheckRange("depth's units_per_m", rig.depth.units_per_m, 0, 1e6));
  RETURN_IF_ERROR(CheckRange("depth's virtual_baseline_m", rig.depth.virtual_baseline_m, 0, 10));
  if (!rig.depth.camera.has_value()) return absl::OkStatus();
  const absl::Status possible = Validate(DepthGeometryOf(rig));
  if (possible.ok()) return possible;
  return absl::InvalidArgumentError(absl::StrCat("depth's ", possible.message()));
}

absl::Status ValidateMonocular(const Rig& rig) {
  if (rig.close_depth_m.has_value()) {
    return absl::InvalidArgumentError(absl::StrCat("close_depth_m is ", *rig.close_depth_m,
                                                   ": one camera alone measures no depth"));
  }
  if (rig.cameras.size() == 1) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("one camera alone is 1 camera, given ", rig.cameras.size()));
}

absl::Status ValidateKind(const Rig& rig) {
  switch (rig.kind) {
    case RigKind::kStereo:
      return ValidateStereo(rig);
    case RigKind::kRgbd:
      return ValidateRgbd(rig);
    case RigKind::kMonocular:
      break;
  }
  return ValidateMonocular(rig);
}

absl::Status ValidateTimeOffset(const Rig& rig) {
  const double offset_s = 1e-9 * static_cast<double>(SecondTimeOffset_ns(rig));
  if (std::abs(offset_s) <= kMostTimeOffset_s) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("time_offset_s: the two cameras differ by ", offset_s, " s, must be at most ",
                   kMostTimeOffset_s, ": is it in seconds, and have they one clock?"));
}

absl::StatusOr<PictureMask> ReadMask(const Rig& rig) {
  if (rig.mask_file.empty()) return PictureMask();
  ASSIGN_OR_RETURN(PictureMask mask, ReadMaskPicture(rig.mask_file));
  const RigCamera& camera = rig.cameras[0];
  if (mask.cols == camera.width_px && mask.rows == camera.height_px) return mask;
  return absl::InvalidArgumentError(
      absl::StrCat(rig.mask_file, ": a mask of ", mask.cols, "x", mask.rows,
                   " pixels, the camera's pictures have ", camera.width_px, "x", camera.height_px,
                   "; give one of this size, black where the robot itself is seen"));
}

// Adds what is improbable about the mask, and names the rig's file beside the mask's.
absl::Status JudgeMask(const Rig& rig, absl::string_view from, SourceFindings& findings) {
  const absl::StatusOr<PictureMask> mask = ReadMask(rig);
  if (!mask.ok()) {
    return absl::Status(mask.status().code(),
                        absl::StrCat(from, ": mask: ", mask.status().message()));
  }
  const double percent = MaskedPercent(*mask);
  if (percent <= kWideMask_percent) return absl::OkStatus();
  findings.push_back(
      {FindingLevel::kWarning, "mask-wide",
       absl::StrFormat("%s: the mask %s leaves out %.1f %% of the picture (more than %.0f %%): is "
                       "it inverted? It is black where the robot itself is seen",
                       from, rig.mask_file, percent, kWideMask_percent)});
  return absl::OkStatus();
}

double Baseline_m(const Rig& rig) {
  return rig.rectified ? rig.baseline_m : rig.right_from_left.translation.norm();
}

StereoCalibration StereoOf(const Rig& rig) {
  StereoCalibration calibration;
  const double baseline_m = Baseline_m(rig);
  if (rig.rectified) {
    calibration.camera = PinholeOf(rig.cameras[0]);
    calibration.camera.baseline_m = baseline_m;
    calibration.right_cx_offset_px = rig.cameras[1].raw.cx_px - rig.cameras[0].raw.cx_px;
  } else {
    calibration.raw = RawPairOf(rig);
  }
  calibration.camera.close_depth_m = rig.close_depth_m.value_or(kCloseDepth_baselines * baseline_m);
  calibration.body_from_raw_left = rig.body_from_camera;
  return calibration;
}

RgbdCalibration RgbdOf(const Rig& rig) {
  RgbdCalibration calibration;
  calibration.camera = PinholeOf(rig.cameras[0]);
  calibration.camera.baseline_m = rig.depth.virtual_baseline_m;
  calibration.camera.close_depth_m =
      rig.close_depth_m.value_or(kCloseDepth_baselines * rig.depth.virtual_baseline_m);
  calibration.lens = rig.cameras[0].raw.lens;
  calibration.depth_units_per_m = rig.depth.units_per_m;
  calibration.body_from_raw = rig.body_from_camera;
  return calibration;
}

MonocularCalibration MonocularOf(const Rig& rig) {
  return {.camera = PinholeOf(rig.cameras[0]),
          .lens = rig.cameras[0].raw.lens,
          .body_from_raw = rig.body_from_camera};
}

SensorCalibration CamerasOf(const Rig& rig) {
  switch (rig.kind) {
    case RigKind::kStereo:
      return StereoOf(rig);
    case RigKind::kRgbd:
      return RgbdOf(rig);
    case RigKind::kMonocular:
      break;
  }
  return MonocularOf(rig);
}

}  // namespace

absl::string_view NameOf(RigKind kind) {
  switch (kind) {
    case RigKind::kStereo:
      return "a stereo pair";
    case RigKind::kRgbd:
      return "an RGB-D camera";
    case RigKind::kMonocular:
      break;
  }
  return "one camera alone";
}

absl::Status Validate(const Rig& rig) {
  for (const RigCamera& camera : rig.cameras) {
    RETURN_IF_ERROR(Validate(PinholeOf(camera)));
    RETURN_IF_ERROR(Validate(camera.raw.lens));
  }
  if (rig.close_depth_m.has_value()) {
    RETURN_IF_ERROR(CheckRange("close_depth_m", *rig.close_depth_m, 0, 1000));
  }
  if (rig.rate_hz.has_value()) RETURN_IF_ERROR(CheckRange("rate_hz", *rig.rate_hz, 0, 1000));
  if (rig.imu.has_value()) RETURN_IF_ERROR(Validate(*rig.imu));
  RETURN_IF_ERROR(ValidateKind(rig));
  return ValidateTimeOffset(rig);
}

int64_t SecondTimeOffset_ns(const Rig& rig) {
  if (rig.kind == RigKind::kMonocular) return 0;
  const double second_s =
      rig.kind == RigKind::kStereo ? rig.cameras[1].time_offset_s : rig.depth.time_offset_s;
  // What no clock differs by is refused by Validate.
  return static_cast<int64_t>(
      std::llround(1e9 * std::clamp(second_s - rig.cameras[0].time_offset_s, -1e6, 1e6)));
}

absl::StatusOr<SourceFindings> JudgeRig(const Rig& rig, absl::string_view from, bool trust) {
  SourceFindings findings;
  RETURN_IF_ERROR(JudgeMask(rig, from, findings));
  std::vector<RigCamera> cameras = rig.cameras;
  if (rig.depth.camera.has_value()) cameras.push_back(*rig.depth.camera);
  for (const RigCamera& camera : cameras) {
    const RawCamera& raw = camera.raw;
    ASSIGN_OR_RETURN(const SourceFindings more,
                     CheckIntrinsics({raw.fx_px, raw.fy_px, raw.cx_px, raw.cy_px, camera.width_px,
                                      camera.height_px},
                                     from, trust));
    findings.insert(findings.end(), more.begin(), more.end());
  }
  if (rig.imu.has_value()) {
    ASSIGN_OR_RETURN(const SourceFindings more, JudgeImu(*rig.imu, from, trust));
    findings.insert(findings.end(), more.begin(), more.end());
  }
  if (rig.kind != RigKind::kStereo) return findings;
  ASSIGN_OR_RETURN(const SourceFindings more, CheckBaseline(Baseline_m(rig), from, trust));
  findings.insert(findings.end(), more.begin(), more.end());
  return findings;
}

absl::StatusOr<SensorCalibration> CalibrationOf(const Rig& rig) {
  RETURN_IF_ERROR(Validate(rig));
  ASSIGN_OR_RETURN(const PictureMask mask, ReadMask(rig));
  SensorCalibration calibration = CamerasOf(rig);
  std::visit(
      [&](auto& kind) {
        kind.mask = mask;
        if (rig.imu.has_value()) kind.imu = CalibrationOf(*rig.imu);
      },
      calibration);
  return calibration;
}

}  // namespace corbslam::client_agent
