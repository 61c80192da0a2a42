// Several coded streams after one another, and a checksum of what they stand for.
#ifndef CORBSLAM_SLAM_CODING_STREAM_FIELDS_H_
#define CORBSLAM_SLAM_CODING_STREAM_FIELDS_H_

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "slam/coding/byte_fields.h"
#include "slam/util/checksum.h"

namespace corbslam {

static_assert(std::endian::native == std::endian::little, "checksums are of columns as they lie");

// Appends the streams' lengths, then the streams.
inline void AppendStreams(std::span<const std::string> streams, std::string* bytes) {
  for (const std::string& stream : streams) {
    AppendNumber(static_cast<uint32_t>(stream.size()), bytes);
  }
  for (const std::string& stream : streams) *bytes += stream;
}

// Returns none where the streams are longer than all that is there.
template <size_t kCount>
std::optional<std::array<std::string_view, kCount>> TakeStreams(FieldReader& fields) {
  std::array<uint32_t, kCount> lengths;
  for (uint32_t& length : lengths) length = fields.Number();
  std::array<std::string_view, kCount> streams;
  for (size_t i = 0; i < kCount; ++i) streams[i] = fields.Piece(lengths[i]);
  if (!fields.ok()) return std::nullopt;
  return streams;
}

template <typename T>
uint32_t ExtendCrc32cBy(uint32_t crc, const std::vector<T>& column) {
  return ExtendCrc32c(crc,
                      {reinterpret_cast<const char*>(column.data()), column.size() * sizeof(T)});
}

inline void AppendChecksum(uint32_t checksum, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&checksum), sizeof(checksum));
}

// Returns whether that checksum, and nothing else, is what is left.
inline bool EndsWithChecksum(FieldReader& fields, uint32_t checksum) {
  if (fields.left() != sizeof(checksum)) return false;
  return std::memcmp(fields.Piece(sizeof(checksum)).data(), &checksum, sizeof(checksum)) == 0;
}

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CODING_STREAM_FIELDS_H_
