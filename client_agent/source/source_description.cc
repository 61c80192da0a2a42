#include "client_agent/source/source_description.h"

#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client_agent/source/pictures/mask_picture.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

std::string CameraModelOf(const LensModel& lens) {
  const bool is_pinhole = std::holds_alternative<RadialTangential>(lens);
  return is_pinhole ? "pinhole, " + DescribeLens(lens) : DescribeLens(lens);
}

std::string DescribeIntrinsics(const SourceDescription& description) {
  const Intrinsics& k = description.intrinsics;
  return absl::StrFormat("fx %.10g fy %.10g cx %.10g cy %.10g px, from %s", k.fx_px, k.fy_px,
                         k.cx_px, k.cy_px, description.intrinsics_from);
}

std::string DescribeTimes(const SourceDescription& description) {
  const TimeStatistics& times = description.times;
  std::string text = absl::StrFormat("%.3g frames/s over %.1f s, from %s", times.rate_hz,
                                     times.duration_s, description.times_from);
  if (times.gaps == 0) return text + "; no gaps";
  absl::StrAppend(&text, absl::StrFormat("; %d gaps, the longest %.1f s before frame %d",
                                         times.gaps, times.longest_gap_s, times.longest_gap_frame));
  return text;
}

Intrinsics IntrinsicsOf(const Camera& camera) {
  return {camera.fx_px, camera.fy_px,    camera.cx_px,
          camera.cy_px, camera.width_px, camera.height_px};
}

void Describe(const StereoCalibration& calibration, SourceDescription& description) {
  if (!calibration.raw.has_value()) {
    description.camera_model = "rectified stereo pair, pinhole";
    description.baseline_m = calibration.camera.baseline_m;
    return;
  }
  const RawStereo& raw = *calibration.raw;
  description.camera_model = absl::StrCat(
      "raw stereo pair, rectified while it is played; left: ", CameraModelOf(raw.left.lens),
      "; right: ", CameraModelOf(raw.right.lens));
  description.baseline_m = raw.right_from_left.translation.norm();
}

void Describe(const RgbdCalibration& calibration, SourceDescription& description) {
  description.camera_model = absl::StrCat("RGB-D, ", CameraModelOf(calibration.lens));
  description.depth_units_per_m = calibration.depth_units_per_m;
}

void Describe(const MonocularCalibration& calibration, SourceDescription& description) {
  description.camera_model = absl::StrCat("one camera alone, ", CameraModelOf(calibration.lens),
                                          "; its map has no metres");
  description.baseline_m.reset();
  description.depth_units_per_m.reset();
}

std::string DescribeDepth(const SourceDescription& description) {
  const std::string text = absl::StrFormat(
      "%.6g units a metre, from %s", *description.depth_units_per_m, description.depth_units_from);
  if (description.depth_registration.empty()) return text;
  return absl::StrCat(text, "; ", description.depth_registration);
}

}  // namespace

Intrinsics RecordedIntrinsics(const SensorCalibration& calibration) {
  return IntrinsicsOf(FirstCameraOf(calibration).camera);
}

void DescribeCamera(const SensorCalibration& calibration, SourceDescription& description) {
  description.intrinsics = RecordedIntrinsics(calibration);
  std::visit([&](const auto& kind) { Describe(kind, description); }, calibration);
  description.masked_percent = MaskedPercent(calibration);
}

std::vector<std::pair<std::string, std::string>> DescribeInLines(
    const SourceDescription& description) {
  const Intrinsics& k = description.intrinsics;
  std::vector<std::pair<std::string, std::string>> lines = {
      {"layout", description.layout},
      {"camera", description.camera_model},
      {"size", absl::StrCat(k.width_px, "x", k.height_px)},
      {"intrinsics", DescribeIntrinsics(description)}};
  if (description.baseline_m.has_value()) {
    lines.push_back({"baseline", absl::StrFormat("%.6g m", *description.baseline_m)});
  }
  if (description.depth_units_per_m.has_value()) {
    lines.push_back({"depth", DescribeDepth(description)});
  }
  if (description.masked_percent > 0) {
    lines.push_back(
        {"mask", absl::StrFormat("leaves out %.1f %% of the picture", description.masked_percent)});
  }
  if (!description.imu.empty()) lines.push_back({"imu", description.imu});
  if (description.is_live) {
    lines.push_back({"times", description.times_from});
    return lines;
  }
  lines.push_back({"frames", absl::StrCat(description.frames)});
  lines.push_back({"times", DescribeTimes(description)});
  for (const std::string& what : description.remarks.left_out) lines.push_back({"left out", what});
  return lines;
}

}  // namespace corbslam::client_agent
