#include "services/convert/features.h"

#include <bit>
#include <cstring>
#include <optional>
#include <utility>

#include "services/convert/errors.h"
#include "services/convert/limits.h"
#include "slam/coding/feature_coding.h"
#include "slam/coding/feature_columns.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

static_assert(std::endian::native == std::endian::little, "descriptors are copied as they lie");

template <typename Column>
absl::Status CheckLength(absl::string_view field, const Column& column, size_t count) {
  if (static_cast<size_t>(column.size()) == count) return absl::OkStatus();
  return BadLength(field, static_cast<int64_t>(column.size()), static_cast<int64_t>(count));
}

absl::Status CheckLengths(const v1::Features& proto) {
  const int count = proto.x_px64_size();
  if (count > kMaxKeypoints) return OutOfRange("number of keypoints", count, 0, kMaxKeypoints);
  if (proto.y_px64_size() != count) return BadLength("y_px64", proto.y_px64_size(), count);
  if (proto.disparity_px128_size() != 0 && proto.disparity_px128_size() != count) {
    return BadLength("disparity_px128", proto.disparity_px128_size(), count);
  }
  if (proto.angle_turn14_size() != count) {
    return BadLength("angle_turn14", proto.angle_turn14_size(), count);
  }
  RETURN_IF_ERROR(CheckLength("octaves", proto.octaves(), static_cast<size_t>(count)));
  if (proto.descriptors().empty()) return absl::OkStatus();
  return CheckLength("descriptors", proto.descriptors(),
                     static_cast<size_t>(count) * sizeof(Descriptor));
}

absl::StatusOr<FeatureColumns> ReadPlainColumns(const v1::Features& proto) {
  RETURN_IF_ERROR(CheckLengths(proto));
  FeatureColumns columns;
  columns.x_px64.assign(proto.x_px64().begin(), proto.x_px64().end());
  columns.y_px64.assign(proto.y_px64().begin(), proto.y_px64().end());
  columns.disparity_px128.assign(proto.disparity_px128().begin(), proto.disparity_px128().end());
  columns.angle_turn14.assign(proto.angle_turn14().begin(), proto.angle_turn14().end());
  columns.octaves = proto.octaves();
  columns.descriptors.resize(proto.descriptors().size() / sizeof(Descriptor));
  if (!columns.descriptors.empty()) {
    std::memcpy(columns.descriptors.data(), proto.descriptors().data(), proto.descriptors().size());
  }
  return columns;
}

// Returns an error if features come both coded and as columns.
absl::Status CheckPlainIsEmpty(const v1::Features& proto) {
  const std::pair<absl::string_view, size_t> fields[] = {
      {"x_px64", proto.x_px64().size()},
      {"y_px64", proto.y_px64().size()},
      {"disparity_px128", proto.disparity_px128().size()},
      {"angle_turn14", proto.angle_turn14().size()},
      {"octaves", proto.octaves().size()},
      {"descriptors", proto.descriptors().size()}};
  for (const auto& [field, size] : fields) {
    if (size == 0) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(field, " has ", size, " entries beside coded, must have none"));
  }
  return absl::OkStatus();
}

absl::StatusOr<FeatureColumns> ReadColumns(const v1::Features& proto) {
  if (proto.coded().empty()) return ReadPlainColumns(proto);
  RETURN_IF_ERROR(CheckPlainIsEmpty(proto));
  return DecodeFeatures(proto.coded(), kMaxKeypoints);
}

absl::Status CheckPosition(absl::string_view field, size_t i, int32_t steps, int side_px) {
  // Undistorted keypoints may lie outside of the image, but not far.
  const double position_px = steps / kPositionSteps_px;
  if (position_px >= -side_px && position_px <= 2 * side_px) return absl::OkStatus();
  return OutOfRange(absl::StrCat(field, "[", i, "] in pixels"), position_px, -side_px, 2 * side_px);
}

absl::Status CheckKeypoint(const FeatureColumns& columns, size_t i, const Camera& camera) {
  RETURN_IF_ERROR(CheckPosition("x_px64", i, columns.x_px64[i], camera.width_px));
  RETURN_IF_ERROR(CheckPosition("y_px64", i, columns.y_px64[i], camera.height_px));
  const uint32_t disparity = columns.disparity_px128.empty() ? 0 : columns.disparity_px128[i];
  if (disparity > kMaxDisparity_px128) {
    return OutOfRange(absl::StrCat("disparity_px128[", i, "]"), disparity, 0u, kMaxDisparity_px128);
  }
  const uint32_t turn = columns.angle_turn14[i];
  if (turn >= kTurnSteps) {
    return OutOfRange(absl::StrCat("angle_turn14[", i, "]"), turn, 0u, kTurnSteps - 1);
  }
  const auto octave = static_cast<uint8_t>(columns.octaves[i]);
  if (octave >= ScalePyramid::kLevels) {
    return OutOfRange(absl::StrCat("octaves[", i, "]"), int{octave}, 0, ScalePyramid::kLevels - 1);
  }
  return absl::OkStatus();
}

void WritePlain(const FeatureColumns& columns, v1::Features* proto) {
  proto->mutable_x_px64()->Add(columns.x_px64.begin(), columns.x_px64.end());
  proto->mutable_y_px64()->Add(columns.y_px64.begin(), columns.y_px64.end());
  proto->mutable_disparity_px128()->Add(columns.disparity_px128.begin(),
                                        columns.disparity_px128.end());
  proto->mutable_angle_turn14()->Add(columns.angle_turn14.begin(), columns.angle_turn14.end());
  proto->set_octaves(columns.octaves);
  proto->set_descriptors(DescriptorsToBytes(columns.descriptors));
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
  WritePlain(ToColumns(features), proto);
}

void ToProto(const KeyframePayload& payload, v1::KeyframePayload* proto, FeatureForm form) {
  proto->set_timestamp_ns(payload.timestamp_ns);
  proto->set_camera_index(payload.camera_index);
  if (const auto code = payload.code.lock(); code != nullptr && form == FeatureForm::kCoded) {
    proto->mutable_features()->set_coded(*code);
    return;
  }
  const FeatureColumns columns = ToColumns(payload.features);
  if (form == FeatureForm::kCoded) {
    const PictureSize picture = {static_cast<uint32_t>(payload.camera->width_px),
                                 static_cast<uint32_t>(payload.camera->height_px)};
    if (std::optional<std::string> coded = EncodeFeatures(columns, picture)) {
      proto->mutable_features()->set_coded(*std::move(coded));
      return;
    }
  }
  WritePlain(columns, proto->mutable_features());
}

absl::StatusOr<Features> FromProto(const v1::Features& proto, const Camera& camera,
                                   bool descriptors_optional) {
  ASSIGN_OR_RETURN(FeatureColumns columns, ReadColumns(proto));
  if (proto.nodes_plus_one_size() != 0) {
    RETURN_IF_ERROR(CheckLength("nodes_plus_one", proto.nodes_plus_one(), columns.size()));
  }
  if (columns.descriptors.empty() && columns.size() > 0 && !descriptors_optional) {
    return BadLength("descriptors", 0, static_cast<int64_t>(columns.size() * sizeof(Descriptor)));
  }
  for (size_t i = 0; i < columns.size(); ++i) {
    RETURN_IF_ERROR(CheckKeypoint(columns, i, camera));
  }
  return FromColumns(std::move(columns));
}

size_t UncodedBytes(const v1::Features& proto) {
  return proto.ByteSizeLong() + CountCodedKeypoints(proto.coded()) * kUncodedKeypointBytes;
}

absl::StatusOr<std::shared_ptr<const KeyframePayload>> FromProto(
    const v1::KeyframePayload& proto, KeyframeId id, const CameraBook& cameras,
    bool descriptors_optional, std::weak_ptr<const std::string> code) {
  RETURN_IF_ERROR(CheckTimestamp(proto.timestamp_ns()));
  KeyframePayload payload;
  payload.id = id;
  payload.timestamp_ns = proto.timestamp_ns();
  payload.camera_index = proto.camera_index();
  payload.camera = cameras.Find(id.local_map, proto.camera_index());
  payload.code = std::move(code);
  if (payload.camera == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat("camera_index is ", proto.camera_index(),
                                                   ", but that camera of local map ",
                                                   ToString(id.local_map), " was never sent"));
  }
  ASSIGN_OR_RETURN(payload.features,
                   FromProto(proto.features(), *payload.camera, descriptors_optional));
  return MakeKeyframePayload(std::move(payload));
}

}  // namespace corbslam::services
