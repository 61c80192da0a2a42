#include "services/convert/features.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

#include "services/convert/errors.h"
#include "services/convert/limits.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

static_assert(std::endian::native == std::endian::little, "descriptors are copied as they lie");

constexpr double kPositionSteps = 64;
constexpr double kDisparitySteps = 128;
constexpr uint32_t kMaxDisparity = 1u << 21;
constexpr int kTurnSteps = 1 << 14;
constexpr double kStepsPerRadian = kTurnSteps / (2 * std::numbers::pi);

int32_t EncodePosition(float position_px) {
  return static_cast<int32_t>(std::lround(position_px * kPositionSteps));
}

uint32_t EncodeDisparity(float disparity_px) {
  if (!(disparity_px > 0)) return 0;
  const double steps = std::round(disparity_px * kDisparitySteps);
  // A known disparity stays known.
  return static_cast<uint32_t>(std::clamp(steps, 1.0, double{kMaxDisparity}));
}

uint32_t EncodeAngle(float angle_rad) {
  const long steps = std::lround(angle_rad * kStepsPerRadian);
  return static_cast<uint32_t>(steps) & (kTurnSteps - 1);
}

float DecodeAngle(uint32_t steps) {
  // (-pi, pi].
  const int centred =
      steps > kTurnSteps / 2 ? static_cast<int>(steps) - kTurnSteps : static_cast<int>(steps);
  return static_cast<float>(centred / kStepsPerRadian);
}

absl::Status CheckLengths(const v1::Features& proto, bool descriptors_optional) {
  const int count = proto.x_px64_size();
  if (count > kMaxKeypoints) return OutOfRange("number of keypoints", count, 0, kMaxKeypoints);
  if (proto.y_px64_size() != count) return BadLength("y_px64", proto.y_px64_size(), count);
  if (proto.disparity_px128_size() != 0 && proto.disparity_px128_size() != count) {
    return BadLength("disparity_px128", proto.disparity_px128_size(), count);
  }
  if (proto.angle_turn14_size() != count) {
    return BadLength("angle_turn14", proto.angle_turn14_size(), count);
  }
  if (proto.nodes_plus_one_size() != 0 && proto.nodes_plus_one_size() != count) {
    return BadLength("nodes_plus_one", proto.nodes_plus_one_size(), count);
  }
  const auto bytes = static_cast<size_t>(count);
  if (proto.octaves().size() != bytes) {
    return BadLength("octaves", static_cast<int64_t>(proto.octaves().size()), count);
  }
  if (proto.descriptors().empty() && descriptors_optional) return absl::OkStatus();
  if (proto.descriptors().size() != bytes * sizeof(Descriptor)) {
    return BadLength("descriptors", static_cast<int64_t>(proto.descriptors().size()),
                     int64_t{count} * static_cast<int64_t>(sizeof(Descriptor)));
  }
  return absl::OkStatus();
}

absl::Status CheckPosition(absl::string_view field, int i, int32_t steps, int side_px) {
  // Undistorted keypoints may lie outside of the image, but not far.
  const double position_px = steps / kPositionSteps;
  if (position_px >= -side_px && position_px <= 2 * side_px) return absl::OkStatus();
  return OutOfRange(absl::StrCat(field, "[", i, "] in pixels"), position_px, -side_px, 2 * side_px);
}

absl::StatusOr<Keypoint> ReadKeypoint(const v1::Features& proto, int i, const Camera& camera) {
  Keypoint keypoint;
  RETURN_IF_ERROR(CheckPosition("x_px64", i, proto.x_px64(i), camera.width_px));
  RETURN_IF_ERROR(CheckPosition("y_px64", i, proto.y_px64(i), camera.height_px));
  keypoint.x_px = static_cast<float>(proto.x_px64(i) / kPositionSteps);
  keypoint.y_px = static_cast<float>(proto.y_px64(i) / kPositionSteps);
  if (proto.disparity_px128_size() != 0) {
    const uint32_t steps = proto.disparity_px128(i);
    if (steps > kMaxDisparity) {
      return OutOfRange(absl::StrCat("disparity_px128[", i, "]"), steps, 0u, kMaxDisparity);
    }
    keypoint.disparity_px = static_cast<float>(steps / kDisparitySteps);
  }
  const uint32_t turn = proto.angle_turn14(i);
  if (turn >= kTurnSteps) {
    return OutOfRange(absl::StrCat("angle_turn14[", i, "]"), turn, 0, kTurnSteps - 1);
  }
  keypoint.angle_rad = DecodeAngle(turn);
  keypoint.octave = static_cast<uint8_t>(proto.octaves()[static_cast<size_t>(i)]);
  if (keypoint.octave >= ScalePyramid::kLevels) {
    return OutOfRange(absl::StrCat("octaves[", i, "]"), int{keypoint.octave}, 0,
                      ScalePyramid::kLevels - 1);
  }
  return keypoint;
}

}  // namespace

absl::Status CameraBook::Add(LocalMapId local_map, uint32_t index,
                             std::shared_ptr<const Camera> camera) {
  if (index > kMaxCameraIndex) return OutOfRange("index of a camera", index, 0u, kMaxCameraIndex);
  if (cameras_.size() >= kMaxCamerasOfStream && Find(local_map, index) == nullptr) {
    return absl::ResourceExhaustedError(
        absl::StrCat("camera ", index, " of local map ", ToString(local_map),
                     " is one too many for this stream; ", "the limit is ", kMaxCamerasOfStream));
  }
  const auto [it, added] = cameras_.try_emplace({local_map, index}, camera);
  if (!added && *it->second != *camera) {
    return absl::InvalidArgumentError(absl::StrCat("camera ", index, " of local map ",
                                                   ToString(local_map), " was another one before"));
  }
  return absl::OkStatus();
}

std::shared_ptr<const Camera> CameraBook::Find(LocalMapId local_map, uint32_t index) const {
  const auto it = cameras_.find({local_map, index});
  return it == cameras_.end() ? nullptr : it->second;
}

std::string DescriptorsToBytes(const std::vector<Descriptor>& descriptors) {
  std::string bytes(descriptors.size() * sizeof(Descriptor), '\0');
  if (!descriptors.empty()) std::memcpy(bytes.data(), descriptors.data(), bytes.size());
  return bytes;
}

void AppendDescriptor(const Descriptor& descriptor, std::string* bytes) {
  const size_t size = bytes->size();
  bytes->resize(size + sizeof(Descriptor));
  std::memcpy(bytes->data() + size, &descriptor, sizeof(Descriptor));
}

Descriptor DescriptorFromBytes(const std::string& bytes, size_t index) {
  Descriptor descriptor;
  std::memcpy(&descriptor, bytes.data() + index * sizeof(Descriptor), sizeof(Descriptor));
  return descriptor;
}

absl::Status CheckTimestamp(int64_t timestamp_ns) {
  if (timestamp_ns >= 0 && timestamp_ns <= kMaxTimestamp_ns) return absl::OkStatus();
  return OutOfRange("timestamp_ns", timestamp_ns, int64_t{0}, kMaxTimestamp_ns);
}

void ToProto(const Features& features, v1::Features* proto) {
  const auto count = static_cast<int>(features.keypoints.size());
  proto->mutable_x_px64()->Reserve(count);
  proto->mutable_y_px64()->Reserve(count);
  proto->mutable_angle_turn14()->Reserve(count);
  const bool any_depth =
      std::ranges::any_of(features.keypoints, [](const Keypoint& k) { return k.HasDepth(); });
  if (any_depth) proto->mutable_disparity_px128()->Reserve(count);
  std::string& octaves = *proto->mutable_octaves();
  octaves.reserve(features.keypoints.size());
  for (const Keypoint& keypoint : features.keypoints) {
    proto->add_x_px64(EncodePosition(keypoint.x_px));
    proto->add_y_px64(EncodePosition(keypoint.y_px));
    if (any_depth) proto->add_disparity_px128(EncodeDisparity(keypoint.disparity_px));
    proto->add_angle_turn14(EncodeAngle(keypoint.angle_rad));
    octaves.push_back(static_cast<char>(keypoint.octave));
  }
  proto->set_descriptors(DescriptorsToBytes(features.descriptors));
}

void ToProto(const KeyframePayload& payload, v1::KeyframePayload* proto) {
  proto->set_timestamp_ns(payload.timestamp_ns);
  proto->set_camera_index(payload.camera_index);
  ToProto(payload.features, proto->mutable_features());
}

absl::StatusOr<Features> FromProto(const v1::Features& proto, const Camera& camera,
                                   bool descriptors_optional) {
  RETURN_IF_ERROR(CheckLengths(proto, descriptors_optional));
  Features features;
  const int count = proto.x_px64_size();
  features.keypoints.reserve(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) {
    ASSIGN_OR_RETURN(const Keypoint keypoint, ReadKeypoint(proto, i, camera));
    features.keypoints.push_back(keypoint);
  }
  features.descriptors.resize(proto.descriptors().size() / sizeof(Descriptor));
  if (!features.descriptors.empty()) {
    std::memcpy(features.descriptors.data(), proto.descriptors().data(),
                proto.descriptors().size());
  }
  return features;
}

absl::StatusOr<std::shared_ptr<const KeyframePayload>> FromProto(const v1::KeyframePayload& proto,
                                                                 KeyframeId id,
                                                                 const CameraBook& cameras,
                                                                 bool descriptors_optional) {
  RETURN_IF_ERROR(CheckTimestamp(proto.timestamp_ns()));
  std::shared_ptr<const Camera> camera = cameras.Find(id.local_map, proto.camera_index());
  if (camera == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat("camera_index is ", proto.camera_index(),
                                                   ", but that camera of local map ",
                                                   ToString(id.local_map), " was never sent"));
  }
  ASSIGN_OR_RETURN(Features features, FromProto(proto.features(), *camera, descriptors_optional));
  return MakeKeyframePayload(id, proto.timestamp_ns(), proto.camera_index(), std::move(camera),
                             std::move(features));
}

}  // namespace corbslam
