#include "slam/coding/feature_coding.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "slam/coding/byte_fields.h"
#include "slam/coding/descriptor_streams.h"
#include "slam/coding/stream_fields.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

// The format is: version, flags, number of keypoints, width, height, length of each stream,
// streams, checksum.
constexpr uint8_t kHasDisparities = 1;
constexpr uint8_t kHasDescriptors = 2;
// A keypoint takes about so many bytes uncoded, without and with its descriptor.
constexpr size_t kPlainBytes = 10;

struct Header {
  uint8_t flags = 0;
  uint32_t count = 0;
  PictureSize picture;
};

uint32_t ChecksumOf(const FeatureColumns& columns) {
  uint32_t crc = ExtendCrc32cBy(0, columns.x_px64);
  crc = ExtendCrc32cBy(crc, columns.y_px64);
  crc = ExtendCrc32cBy(crc, columns.disparity_px128);
  crc = ExtendCrc32cBy(crc, columns.angle_turn14);
  crc = ExtendCrc32c(crc, columns.octaves);
  return ExtendCrc32cBy(crc, columns.descriptors);
}

bool IsSide(uint32_t side_px) { return side_px >= 1 && side_px <= kMaxCodedSide_px; }

bool CanCode(const FeatureColumns& columns, const PictureSize& picture) {
  const size_t count = columns.size();
  const auto has_length = [count](const auto& column) { return column.size() == count; };
  const bool lengths = has_length(columns.y_px64) && has_length(columns.angle_turn14) &&
                       has_length(columns.octaves) &&
                       (columns.disparity_px128.empty() || has_length(columns.disparity_px128)) &&
                       (columns.descriptors.empty() || has_length(columns.descriptors));
  return count > 0 && count <= UINT32_MAX && lengths && IsSide(picture.width_px) &&
         IsSide(picture.height_px) &&
         std::ranges::all_of(columns.angle_turn14, [](uint32_t a) { return a < kTurnSteps; }) &&
         std::ranges::all_of(columns.disparity_px128,
                             [](uint32_t d) { return d <= kMaxDisparity_px128; });
}

std::string EncodeKeypoints(const FeatureColumns& columns, const PictureSize& picture) {
  const bool has_disparities = !columns.disparity_px128.empty();
  KeypointModel model(picture, has_disparities);
  BitWriter writer;
  for (size_t i = 0; i < columns.size(); ++i) {
    CodedKeypoint keypoint{columns.x_px64[i], columns.y_px64[i],
                           has_disparities ? columns.disparity_px128[i] : 0,
                           columns.angle_turn14[i], static_cast<uint8_t>(columns.octaves[i])};
    model.Code(writer, keypoint);
  }
  return writer.Finish();
}

absl::Status Malformed(absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat("coded features: ", what));
}

absl::Status DecodeKeypoints(const Header& header, std::string_view stream,
                             FeatureColumns& columns) {
  const bool has_disparities = (header.flags & kHasDisparities) != 0;
  KeypointModel model(header.picture, has_disparities);
  BitReader reader(stream);
  for (uint32_t i = 0; i < header.count && !reader.exhausted(); ++i) {
    CodedKeypoint keypoint;
    model.Code(reader, keypoint);
    columns.x_px64.push_back(keypoint.x_px64);
    columns.y_px64.push_back(keypoint.y_px64);
    if (has_disparities) columns.disparity_px128.push_back(keypoint.disparity_px128);
    columns.angle_turn14.push_back(keypoint.angle_turn14);
    columns.octaves.push_back(static_cast<char>(keypoint.octave));
  }
  if (reader.done() && columns.size() == header.count) return absl::OkStatus();
  return Malformed(absl::StrCat("the stream of keypoints is not that of ", header.count));
}

absl::StatusOr<Header> ReadHeader(FieldReader& fields, size_t max_keypoints) {
  const size_t bytes = fields.left();
  const std::string_view start = fields.Piece(2);
  if (start.size() < 2) return Malformed(absl::StrCat("cut short, ", bytes, " bytes"));
  if (static_cast<uint8_t>(start[0]) != kFeatureCodingVersion) {
    return Malformed(absl::StrCat("version is ", static_cast<uint8_t>(start[0]),
                                  ", this program reads ", kFeatureCodingVersion));
  }
  Header header;
  header.flags = static_cast<uint8_t>(start[1]);
  if (header.flags > (kHasDisparities | kHasDescriptors)) {
    return Malformed(absl::StrCat("flags are ", header.flags, ", must be 0 to ",
                                  kHasDisparities | kHasDescriptors));
  }
  header.count = fields.Number();
  header.picture = {fields.Number(), fields.Number()};
  if (!fields.ok()) return Malformed("cut short in its header");
  if (header.count > max_keypoints) {
    return Malformed(
        absl::StrCat("number of keypoints is ", header.count, ", the limit is ", max_keypoints));
  }
  if (bytes / kMinCodedBytesOfKeypoint < header.count) {
    return Malformed(absl::StrCat(bytes, " bytes for ", header.count, " keypoints, must be ",
                                  kMinCodedBytesOfKeypoint, " each"));
  }
  if (header.count == 0 || !IsSide(header.picture.width_px) || !IsSide(header.picture.height_px)) {
    return Malformed(absl::StrCat(header.count, " keypoints of a picture of ",
                                  header.picture.width_px, "x", header.picture.height_px,
                                  ", must be 1 or more of sides of 1 to ", kMaxCodedSide_px));
  }
  return header;
}

absl::Status DecodeStreams(const Header& header, FieldReader& fields, FeatureColumns& columns) {
  constexpr char kTooLong[] = "cut short, or a stream is longer than all there is";
  if ((header.flags & kHasDescriptors) == 0) {
    const auto streams = TakeStreams<1>(fields);
    if (!streams.has_value()) return Malformed(kTooLong);
    return DecodeKeypoints(header, streams->front(), columns);
  }
  const auto streams = TakeStreams<1 + kDescriptorStreams>(fields);
  if (!streams.has_value()) return Malformed(kTooLong);
  RETURN_IF_ERROR(DecodeKeypoints(header, streams->front(), columns));
  columns.descriptors.resize(header.count);
  std::array<std::string_view, kDescriptorStreams> of_descriptors;
  std::copy(streams->begin() + 1, streams->end(), of_descriptors.begin());
  if (DecodeDescriptors(of_descriptors, columns.descriptors)) return absl::OkStatus();
  return Malformed(absl::StrCat("the streams of descriptors are not those of ", header.count));
}

}  // namespace

std::optional<std::string> EncodeFeatures(const FeatureColumns& columns,
                                          const PictureSize& picture) {
  if (!CanCode(columns, picture)) return std::nullopt;
  const bool has_descriptors = !columns.descriptors.empty();
  std::vector<std::string> streams = {EncodeKeypoints(columns, picture)};
  if (has_descriptors) {
    for (std::string& stream : EncodeDescriptors(columns.descriptors)) {
      streams.push_back(std::move(stream));
    }
  }
  std::string bytes = {static_cast<char>(kFeatureCodingVersion),
                       static_cast<char>((columns.disparity_px128.empty() ? 0 : kHasDisparities) |
                                         (has_descriptors ? kHasDescriptors : 0))};
  AppendNumber(static_cast<uint32_t>(columns.size()), &bytes);
  AppendNumber(picture.width_px, &bytes);
  AppendNumber(picture.height_px, &bytes);
  AppendStreams(streams, &bytes);
  AppendChecksum(ChecksumOf(columns), &bytes);
  const size_t plain = columns.size() * (kPlainBytes + (has_descriptors ? sizeof(Descriptor) : 0));
  if (bytes.size() > plain || bytes.size() < columns.size() * kMinCodedBytesOfKeypoint) {
    return std::nullopt;
  }
  return bytes;
}

absl::StatusOr<FeatureColumns> DecodeFeatures(std::string_view bytes, size_t max_keypoints) {
  FieldReader fields(bytes);
  ASSIGN_OR_RETURN(const Header header, ReadHeader(fields, max_keypoints));
  FeatureColumns columns;
  RETURN_IF_ERROR(DecodeStreams(header, fields, columns));
  if (!EndsWithChecksum(fields, ChecksumOf(columns))) {
    return Malformed("the checksum differs, or more follows it");
  }
  return columns;
}

size_t CountCodedKeypoints(std::string_view bytes) {
  FieldReader fields(bytes);
  fields.Piece(2);
  return std::min<size_t>(fields.Number(), bytes.size() / kMinCodedBytesOfKeypoint);
}

}  // namespace corbslam
