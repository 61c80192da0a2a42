#include "fusion_worker/view_validation.h"

#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "slam/camera/camera.h"

namespace corbslam::fusion_worker {
namespace {

constexpr double kUnitTolerance = 1e-3;

bool IsFinite(const Keypoint& keypoint) {
  return std::isfinite(keypoint.x_px) && std::isfinite(keypoint.y_px) &&
         std::isfinite(keypoint.disparity_px) && std::isfinite(keypoint.angle_rad);
}

absl::Status CheckKeypoints(const Keyframe& keyframe) {
  const auto& keypoints = keyframe.keypoints();
  for (size_t i = 0; i < keypoints.size(); ++i) {
    if (IsFinite(keypoints[i]) && keypoints[i].octave < ScalePyramid::kLevels) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        "keypoint ", i, " of keyframe ", ToString(keyframe.id()), " is not finite or its octave ",
        keypoints[i].octave, " is beyond the pyramid"));
  }
  return absl::OkStatus();
}

absl::Status CheckKeyframe(KeyframeId id, const Keyframe& keyframe) {
  if (keyframe.payload == nullptr || keyframe.payload->camera == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat("keyframe ", ToString(id), " has no payload or no camera"));
  }
  if (const absl::Status status = Validate(keyframe.camera()); !status.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat("camera of keyframe ", ToString(id), ": ", std::string(status.message())));
  }
  const Rigid3d& pose = keyframe.camera_from_map;
  const double length = pose.rotation.norm();
  if (!pose.translation.allFinite() || !(std::abs(length - 1) < kUnitTolerance)) {
    return absl::InvalidArgumentError(absl::StrCat("keyframe ", ToString(id),
                                                   " has a pose that is not finite or a "
                                                   "quaternion of length ",
                                                   length));
  }
  return CheckKeypoints(keyframe);
}

}  // namespace

absl::Status CheckView(const Map& view) {
  for (const auto& [id, keyframe] : view.keyframes()) {
    if (const absl::Status status = CheckKeyframe(id, keyframe); !status.ok()) return status;
  }
  for (const auto& [id, point] : view.points()) {
    if (point.position_in_map.allFinite() && point.normal_in_map.allFinite()) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("map point ", ToString(id), " has a position or normal that is not finite"));
  }
  return absl::OkStatus();
}

}  // namespace corbslam::fusion_worker
