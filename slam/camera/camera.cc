#include "slam/camera/camera.h"

#include <cmath>

#include "absl/strings/str_cat.h"

namespace corbslam {
namespace {

constexpr int kMaxImageSide_px = 16384;

absl::Status CheckRange(absl::string_view field, double value, double low, double high) {
  if (std::isfinite(value) && value >= low && value <= high) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("camera.", field, " is ", value, ", must be in [", low, ", ", high, "]"));
}

// Some datasets publish a negative focal length for pictures whose y axis points up.
absl::Status CheckFocalLength(absl::string_view field, double value) {
  const absl::Status status = CheckRange(field, value, 1, 1e5);
  if (status.ok() || !(value < 0)) return status;
  return absl::InvalidArgumentError(absl::StrCat(
      status.message(), " (rows are counted downwards here: without the sign, if that is why)"));
}

}  // namespace

absl::Status Validate(const Camera& camera) {
  absl::Status status = CheckFocalLength("fx_px", camera.fx_px);
  status.Update(CheckFocalLength("fy_px", camera.fy_px));
  status.Update(CheckRange("cx_px", camera.cx_px, -1e5, 1e5));
  status.Update(CheckRange("cy_px", camera.cy_px, -1e5, 1e5));
  status.Update(CheckRange("width_px", camera.width_px, 16, kMaxImageSide_px));
  status.Update(CheckRange("height_px", camera.height_px, 16, kMaxImageSide_px));
  status.Update(CheckRange("baseline_m", camera.baseline_m, 0, 1e3));
  status.Update(CheckRange("close_depth_m", camera.close_depth_m, 0, 1e6));
  return status;
}

}  // namespace corbslam
