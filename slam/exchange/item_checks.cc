#include "slam/exchange/item_checks.h"

#include <cmath>
#include <string>

#include "absl/functional/function_ref.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

// Positions beyond this are no place on earth; squares of it are far from overflow.
constexpr double kMaxCoordinate = 1e8;
constexpr double kUnitNormTolerance = 1e-3;
// Normals travel in small numbers.
constexpr double kNormalTolerance = 0.02;
constexpr double kMinScale = 1e-6;
constexpr double kMaxScale = 1e6;
constexpr int64_t kMaxTime_ns = int64_t{1} << 62;
constexpr double kMaxDisparity_px = 16384;

// Of the item, made when something is wrong with it.
using Name = absl::FunctionRef<std::string()>;

template <typename Id>
auto NameOf(absl::string_view what, Id id) {
  return [what, id] { return absl::StrCat(what, " ", ToString(id)); };
}

// Written so that NaN fails.
bool IsWithin(double value, double low, double high) { return value >= low && value <= high; }

template <typename Value, typename Limit>
absl::Status OutOfRange(Name what, absl::string_view field, Value value, Limit low, Limit high) {
  return absl::InvalidArgumentError(
      absl::StrCat(what(), ": ", field, " is ", value, ", must be in [", low, ", ", high, "]"));
}

absl::Status CheckTime(Name what, int64_t time_ns) {
  if (time_ns >= 0 && time_ns <= kMaxTime_ns) return absl::OkStatus();
  return OutOfRange(what, "timestamp_ns", time_ns, int64_t{0}, kMaxTime_ns);
}

absl::Status CheckPosition(Name what, absl::string_view field, const Eigen::Vector3d& position) {
  for (const double value : position) {
    if (!IsWithin(value, -kMaxCoordinate, kMaxCoordinate)) {
      return OutOfRange(what, field, value, -kMaxCoordinate, kMaxCoordinate);
    }
  }
  return absl::OkStatus();
}

absl::Status CheckRotation(Name what, absl::string_view field, const Eigen::Quaterniond& rotation) {
  const double length = rotation.norm();
  if (IsWithin(length, 1 - kUnitNormTolerance, 1 + kUnitNormTolerance)) return absl::OkStatus();
  return OutOfRange(what, absl::StrCat("length of the quaternion of ", field), length,
                    1 - kUnitNormTolerance, 1 + kUnitNormTolerance);
}

// No keyframe at all, or one with a whole id that is not the child.
absl::Status CheckParent(Name what, KeyframeId child, KeyframeId parent) {
  if (parent == KeyframeId()) return absl::OkStatus();
  if (!parent.IsValid()) return absl::InvalidArgumentError(absl::StrCat(what(), ": half a parent"));
  if (parent != child) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(what(), " is its own parent"));
}

absl::Status CheckKeypoint(Name what, size_t i, const Keypoint& keypoint, const Camera& camera) {
  const auto check = [&](absl::string_view field, double value, double low, double high) {
    if (IsWithin(value, low, high)) return absl::OkStatus();
    return OutOfRange(what, absl::StrCat(field, " of keypoint ", i), value, low, high);
  };
  // Undistorted keypoints may lie outside of the image, but not far.
  RETURN_IF_ERROR(check("x_px", keypoint.x_px, -camera.width_px, 2 * camera.width_px));
  RETURN_IF_ERROR(check("y_px", keypoint.y_px, -camera.height_px, 2 * camera.height_px));
  RETURN_IF_ERROR(
      check("disparity_px", keypoint.disparity_px, -kMaxDisparity_px, kMaxDisparity_px));
  RETURN_IF_ERROR(check("angle_rad", keypoint.angle_rad, -7, 7));
  return check("octave", keypoint.octave, 0, ScalePyramid::kLevels - 1);
}

absl::Status CheckFeatures(Name what, const Features& features, const Camera& camera) {
  const size_t count = features.keypoints.size();
  if (features.descriptors.size() != count) {
    return absl::InvalidArgumentError(absl::StrCat(what(), " has ", count, " keypoints but ",
                                                   features.descriptors.size(), " descriptors"));
  }
  for (size_t i = 0; i < count; ++i) {
    RETURN_IF_ERROR(CheckKeypoint(what, i, features.keypoints[i], camera));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ValidateTime(absl::string_view what, int64_t time_ns) {
  return CheckTime([what] { return std::string(what); }, time_ns);
}

absl::Status ValidatePosition(absl::string_view what, MapPointId id, absl::string_view field,
                              const Eigen::Vector3d& position) {
  return CheckPosition(NameOf(what, id), field, position);
}

absl::Status ValidatePose(absl::string_view what, KeyframeId id, absl::string_view field,
                          const Rigid3d& pose) {
  const auto item = NameOf(what, id);
  RETURN_IF_ERROR(CheckRotation(item, field, pose.rotation));
  return CheckPosition(item, field, pose.translation);
}

absl::Status ValidateSimilarity(absl::string_view what, KeyframeId id,
                                const Similarity3d& similarity) {
  RETURN_IF_ERROR(
      ValidatePose(what, id, "b_from_a", {similarity.rotation, similarity.translation}));
  if (IsWithin(similarity.scale, kMinScale, kMaxScale)) return absl::OkStatus();
  return OutOfRange(NameOf(what, id), "scale", similarity.scale, kMinScale, kMaxScale);
}

absl::Status ValidateFullKeyframe(const FullKeyframe& keyframe, const Camera& camera) {
  const KeyframePayload& payload = *keyframe.payload;
  const auto what = NameOf("full keyframe", payload.id);
  RETURN_IF_ERROR(CheckTime(what, payload.timestamp_ns));
  RETURN_IF_ERROR(
      ValidatePose("full keyframe", payload.id, "camera_from_local", keyframe.camera_from_local));
  RETURN_IF_ERROR(CheckParent(what, payload.id, keyframe.parent));
  if (payload.camera != nullptr && !(*payload.camera == camera)) {
    return absl::InvalidArgumentError(absl::StrCat(what(), " carries another camera than index ",
                                                   payload.camera_index, " names"));
  }
  return CheckFeatures(what, payload.features, camera);
}

absl::Status ValidateLightKeyframe(const LightKeyframe& keyframe) {
  const auto what = NameOf("light keyframe", keyframe.id);
  RETURN_IF_ERROR(
      ValidatePose("light keyframe", keyframe.id, "camera_from_local", keyframe.camera_from_local));
  return CheckParent(what, keyframe.id, keyframe.parent);
}

absl::Status ValidateRemoval(const KeyframeRemoval& removal) {
  const auto what = NameOf("removed keyframe", removal.id);
  RETURN_IF_ERROR(ValidatePose("removed keyframe", removal.id, "parent_from_removed",
                               removal.parent_from_removed));
  return CheckParent(what, removal.id, removal.parent);
}

absl::Status ValidateFullPoint(const FullMapPoint& point) {
  const auto what = NameOf("full map point", point.id);
  RETURN_IF_ERROR(CheckPosition(what, "position", point.position_in_local));
  const double length = point.normal_in_local.norm();
  if (length != 0 && !IsWithin(length, 1 - kNormalTolerance, 1 + kNormalTolerance)) {
    return OutOfRange(what, "length of the normal", length, 1 - kNormalTolerance,
                      1 + kNormalTolerance);
  }
  if (!IsWithin(point.min_distance, 0, kMaxCoordinate)) {
    return OutOfRange(what, "min_distance", point.min_distance, 0., kMaxCoordinate);
  }
  if (!IsWithin(point.max_distance, point.min_distance, kMaxCoordinate)) {
    return OutOfRange(what, "max_distance", point.max_distance, point.min_distance, kMaxCoordinate);
  }
  if (point.reference != KeyframeId() && !point.reference.IsValid()) {
    return absl::InvalidArgumentError(absl::StrCat(what(), ": half a reference"));
  }
  return absl::OkStatus();
}

}  // namespace corbslam
