#include "slam/camera/recorded_camera.h"

#include <cmath>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

// These limits are those that the wire sets for a Camera.
constexpr double kMaxFocalLength_px = 1e5;
constexpr double kMaxBodyDistance_m = 1000;
constexpr double kMaxLengthError = 0.01;
constexpr double kMaxOffset_m = 1e-9;

absl::Status ValidateLens(const RawCamera& lens) {
  for (const auto& [name, focal_px] : {std::pair("fx_px", lens.fx_px), {"fy_px", lens.fy_px}}) {
    if (focal_px >= 1 && focal_px <= kMaxFocalLength_px) continue;
    return absl::InvalidArgumentError(absl::StrCat("recorded camera: ", name, " is ", focal_px,
                                                   ", must be in [1, ", kMaxFocalLength_px, "]"));
  }
  for (const auto& [name, centre_px] : {std::pair("cx_px", lens.cx_px), {"cy_px", lens.cy_px}}) {
    if (std::abs(centre_px) <= kMaxFocalLength_px) continue;
    return absl::InvalidArgumentError(absl::StrCat("recorded camera: ", name, " is ", centre_px,
                                                   ", must be within ", kMaxFocalLength_px));
  }
  return Validate(lens.lens);
}

absl::Status ValidateMotion(absl::string_view name, const Rigid3d& motion, double max_m) {
  const double length_error = std::abs(motion.rotation.norm() - 1);
  const double distance_m = motion.translation.norm();
  // The comparison is written so that NaN is refused.
  if (length_error <= kMaxLengthError && distance_m <= max_m) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "recorded camera: ", name, " has a quaternion of length ", motion.rotation.norm(),
      " and a translation of ", distance_m, " m; must be 1 and at most ", max_m, " m"));
}

bool IsIdentity(const Rigid3d& motion) {
  return motion.translation.isZero(0) && motion.rotation.vec().isZero(0);
}

bool IsSame(const Rigid3d& a, const Rigid3d& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation;
}

}  // namespace

bool operator==(const RecordedCamera& a, const RecordedCamera& b) {
  if (a.body_from_recorded.has_value() != b.body_from_recorded.has_value()) return false;
  return a.lens == b.lens && IsSame(a.camera_from_recorded, b.camera_from_recorded) &&
         (!a.body_from_recorded.has_value() ||
          IsSame(*a.body_from_recorded, *b.body_from_recorded));
}

absl::Status Validate(const RecordedCamera& recorded) {
  RETURN_IF_ERROR(ValidateLens(recorded.lens));
  RETURN_IF_ERROR(
      ValidateMotion("camera_from_recorded", recorded.camera_from_recorded, kMaxOffset_m));
  if (!recorded.body_from_recorded.has_value()) return absl::OkStatus();
  return ValidateMotion("body_from_recorded", *recorded.body_from_recorded, kMaxBodyDistance_m);
}

RecordedCamera AsRecorded(const Camera& camera) {
  RecordedCamera recorded;
  recorded.lens = {camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px, {}};
  return recorded;
}

Eigen::Vector2d RecordedPixel(const Camera& camera, const RecordedCamera& recorded,
                              const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d ray = recorded.camera_from_recorded.rotation.conjugate() *
                              Unproject(camera, pixel.x(), pixel.y(), 1);
  const RawCamera& raw = recorded.lens;
  if (const auto* const pinhole = std::get_if<RadialTangential>(&raw.lens)) {
    const Eigen::Vector2d bent = Distort(*pinhole, ray.head<2>() / ray.z());
    return {raw.fx_px * bent.x() + raw.cx_px, raw.fy_px * bent.y() + raw.cy_px};
  }
  return ProjectRaw(raw, ray).value_or(Eigen::Vector2d(-1, -1));
}

absl::string_view ToString(PosesOf poses_of) {
  switch (poses_of) {
    case PosesOf::kRecordedCamera:
      return "camera";
    case PosesOf::kRectifiedCamera:
      return "rectified";
    case PosesOf::kBody:
      return "body";
  }
  return "";
}

absl::StatusOr<PosesOf> ParsePosesOf(absl::string_view text) {
  for (const PosesOf known :
       {PosesOf::kRecordedCamera, PosesOf::kRectifiedCamera, PosesOf::kBody}) {
    if (text == ToString(known)) return known;
  }
  return absl::InvalidArgumentError(
      absl::StrCat("poses of '", text, "': must be camera, rectified or body"));
}

absl::string_view Describe(PosesOf poses_of) {
  switch (poses_of) {
    case PosesOf::kRecordedCamera:
      return "the camera as recorded (of a stereo pair the left one)";
    case PosesOf::kRectifiedCamera:
      return "the rectified camera (of a stereo pair the left one)";
    case PosesOf::kBody:
      return "the body";
  }
  return "";
}

absl::StatusOr<std::optional<Rigid3d>> CameraFromWanted(
    const std::optional<RecordedCamera>& recorded, PosesOf wanted) {
  if (wanted == PosesOf::kRectifiedCamera) return std::nullopt;
  Rigid3d camera_from_wanted;
  if (recorded.has_value()) camera_from_wanted = recorded->camera_from_recorded;
  if (wanted == PosesOf::kBody) {
    if (!recorded.has_value() || !recorded->body_from_recorded.has_value()) {
      return absl::FailedPreconditionError(
          "poses of the body are not known: no calibration says where the camera sits on it. Say "
          "it "
          "by body_from_camera in the rig file (--rig, docs/rig.md; a EuRoC recording has it as "
          "T_BS "
          "in cam0/sensor.yaml) and start the robot anew, or ask for poses of the camera");
    }
    camera_from_wanted = camera_from_wanted * recorded->body_from_recorded->Inverse();
  }
  // No multiplication by an identity may change the last digit.
  if (IsIdentity(camera_from_wanted)) return std::nullopt;
  return camera_from_wanted;
}

}  // namespace corbslam
