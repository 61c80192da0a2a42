#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client_agent/source/calibration/lens_names.h"
#include "client_agent/source/rig/rig_file.h"
#include "client_agent/source/rig/rig_part.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

std::string Listed(const std::vector<double>& numbers) {
  return absl::StrCat("[",
                      absl::StrJoin(numbers, ", ",
                                    [](std::string* out, double number) {
                                      absl::StrAppend(out, FormatReal(number));
                                    }),
                      "]");
}

std::string Listed(const Rigid3d& motion) {
  const Eigen::Matrix3d r = motion.rotation.toRotationMatrix();
  const Eigen::Vector3d& t = motion.translation;
  std::vector<double> rows;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) rows.push_back(r(i, k));
    rows.push_back(t(i));
  }
  rows.insert(rows.end(), {0, 0, 0, 1});
  return Listed(rows);
}

// Appends a camera's fields, each with four blanks before it.
void AppendCamera(const RigCamera& camera, std::string& text) {
  const RawCamera& raw = camera.raw;
  absl::StrAppend(&text, "size_px: [", camera.width_px, ", ", camera.height_px, "]\n");
  absl::StrAppend(&text, "    focal_px: ", Listed({raw.fx_px, raw.fy_px}), "\n");
  absl::StrAppend(&text, "    principal_px: ", Listed({raw.cx_px, raw.cy_px}), "\n");
  if (camera.time_offset_s != 0) {
    absl::StrAppend(&text, "    time_offset_s: ", FormatReal(camera.time_offset_s), "\n");
  }
  const std::vector<double> numbers = NumbersOf(raw.lens);
  if (numbers.empty()) return;
  absl::StrAppend(&text, "    lens: ", std::string(NameOf(raw.lens)), "\n");
  absl::StrAppend(&text, "    lens_numbers: ", Listed(numbers), "\n");
}

void AppendDepth(const RigDepth& depth, std::string& text) {
  absl::StrAppend(&text, "depth:\n  units_per_m: ", FormatReal(depth.units_per_m),
                  "\n  virtual_baseline_m: ", FormatReal(depth.virtual_baseline_m), "\n");
  if (depth.time_offset_s != 0) {
    absl::StrAppend(&text, "  time_offset_s: ", FormatReal(depth.time_offset_s), "\n");
  }
  if (!depth.no_depth.empty()) {
    absl::StrAppend(&text, "  no_depth: ", Listed(depth.no_depth), "\n");
  }
  if (!depth.camera.has_value()) return;
  absl::StrAppend(&text, "  camera:\n    ");
  AppendCamera(*depth.camera, text);
  absl::StrAppend(&text, "  colour_from_depth: ", Listed(depth.colour_from_depth), "\n");
}

void AppendImu(const StatedImu& imu, std::string& text) {
  absl::StrAppend(&text, "imu:\n  imu_from_camera: ", Listed(imu.imu_from_camera), "\n");
  const auto add = [&](absl::string_view field, std::optional<double> number) {
    if (number.has_value()) absl::StrAppend(&text, "  ", field, ": ", FormatReal(*number), "\n");
  };
  add("rate_hz", imu.rate_hz);
  add("gyro_noise", imu.gyro_noise);
  add("accel_noise", imu.accel_noise);
  add("gyro_walk", imu.gyro_walk);
  add("accel_walk", imu.accel_walk);
  if (imu.time_offset_s != 0) add("time_offset_s", imu.time_offset_s);
}

absl::string_view WordOf(RigKind kind) {
  switch (kind) {
    case RigKind::kStereo:
      return "stereo";
    case RigKind::kRgbd:
      return "rgbd";
    case RigKind::kMonocular:
      break;
  }
  return "monocular";
}

void AppendKind(const Rig& rig, std::string& text) {
  if (rig.kind == RigKind::kMonocular) return;
  if (rig.kind == RigKind::kRgbd) return AppendDepth(rig.depth, text);
  absl::StrAppend(&text, "rectified: ", rig.rectified ? "true" : "false", "\n");
  if (rig.rectified) {
    absl::StrAppend(&text, "baseline_m: ", FormatReal(rig.baseline_m), "\n");
    return;
  }
  absl::StrAppend(&text, "right_from_left: ", Listed(rig.right_from_left), "\n");
  if (rig.widest_field_deg != Rig().widest_field_deg) {
    absl::StrAppend(&text, "widest_field_deg: ", FormatReal(rig.widest_field_deg), "\n");
  }
}

}  // namespace

std::string FormatRig(const Rig& rig, const std::string& origin) {
  std::string text =
      absl::StrCat("# A rig file of CORB-SLAM (docs/rig.md), made of ", origin,
                   "\nrig: ", kRigFormat, "\nkind: ", WordOf(rig.kind), "\ncameras:\n");
  for (const RigCamera& camera : rig.cameras) {
    absl::StrAppend(&text, "  - ");
    AppendCamera(camera, text);
  }
  AppendKind(rig, text);
  if (rig.body_from_camera.has_value()) {
    absl::StrAppend(&text, "body_from_camera: ", Listed(*rig.body_from_camera), "\n");
  }
  if (rig.close_depth_m.has_value()) {
    absl::StrAppend(&text, "close_depth_m: ", FormatReal(*rig.close_depth_m), "\n");
  }
  if (rig.rate_hz.has_value()) absl::StrAppend(&text, "rate_hz: ", FormatReal(*rig.rate_hz), "\n");
  if (rig.imu.has_value()) AppendImu(*rig.imu, text);
  if (!rig.mask_file.empty()) absl::StrAppend(&text, "mask: ", rig.mask_file, "\n");
  return text;
}

}  // namespace corbslam::client_agent
