#include "map_store/archive/feature_archive.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/archive/state_fields.h"
#include "map_store/archive/unreadable.h"
#include "slam/coding/feature_coding.h"
#include "slam/coding/feature_columns.h"

namespace corbslam::map_store {
namespace {

// This mark stands where plain features have their number of keypoints, which is never so large:
// coded features follow.
constexpr uint64_t kCodedMark = ~uint64_t{0};

bool SameBits(const Features& a, const Features& b) {
  const auto same = [](float x, float y) {
    return std::bit_cast<uint32_t>(x) == std::bit_cast<uint32_t>(y);
  };
  return a.descriptors == b.descriptors &&
         std::ranges::equal(a.keypoints, b.keypoints, [&](const Keypoint& k, const Keypoint& l) {
           return same(k.x_px, l.x_px) && same(k.y_px, l.y_px) &&
                  same(k.disparity_px, l.disparity_px) && same(k.angle_rad, l.angle_rad) &&
                  k.octave == l.octave;
         });
}

// Returns nullopt where coding would not keep every bit: features that never passed the wire are
// not rounded.
std::optional<std::string> CodeExactly(const KeyframePayload& payload) {
  if (const auto code = payload.code.lock()) return *code;
  FeatureColumns columns = ToColumns(payload.features);
  if (payload.camera == nullptr || !SameBits(FromColumns(columns), payload.features)) {
    return std::nullopt;
  }
  return corbslam::EncodeFeatures(columns, {static_cast<uint32_t>(payload.camera->width_px),
                                            static_cast<uint32_t>(payload.camera->height_px)});
}

absl::StatusOr<Features> DecodeCoded(std::string_view bytes) {
  absl::StatusOr<FeatureColumns> columns =
      corbslam::DecodeFeatures(bytes, std::numeric_limits<size_t>::max());
  if (columns.ok()) return FromColumns(*std::move(columns));
  return absl::DataLossError(
      absl::StrCat("a keyframe's features can't be read: ", columns.status().message()));
}

}  // namespace

std::string EncodeFeatures(const KeyframePayload& payload) {
  ArchiveWriter writer;
  if (const std::optional<std::string> coded = CodeExactly(payload)) {
    writer(kCodedMark);
    writer.Raw(coded->data(), coded->size());
  } else {
    writer(payload.features);
  }
  return writer.Take();
}

absl::StatusOr<Features> DecodeFeatures(std::string_view bytes) {
  ArchiveReader reader(bytes);
  if (uint64_t mark = 0; bytes.size() >= sizeof(mark)) {
    std::memcpy(&mark, bytes.data(), sizeof(mark));
    if (mark == kCodedMark) return DecodeCoded(bytes.substr(sizeof(mark)));
  }
  Features features;
  reader(features);
  if (!reader.done() ||
      (!features.descriptors.empty() && features.descriptors.size() != features.keypoints.size())) {
    return Unreadable("a keyframe's features");
  }
  return features;
}

}  // namespace corbslam::map_store
