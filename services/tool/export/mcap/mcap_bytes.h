// Puts together the bytes of MCAP's records: little-endian numbers, texts and maps behind their
// lengths (https://mcap.dev/spec).
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MCAP_BYTES_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MCAP_BYTES_H_

#include <zlib.h>

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

#include "absl/strings/string_view.h"

namespace corbslam::services {

// First byte of each record.
enum class McapOpcode : uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0b,
  kMetadata = 0x0c,
  kMetadataIndex = 0x0d,
  kDataEnd = 0x0f,
};

// What a file begins and ends with.
inline constexpr absl::string_view kMcapMagic = "\x89MCAP0\r\n";

// Returns the checksum (CRC-32) of what `crc` is of and these bytes behind it; of nothing it is 0.
inline uint32_t ExtendMcapCrc(uint32_t crc, absl::string_view bytes) {
  return static_cast<uint32_t>(
      crc32_z(crc, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

// A record's content, or part of it, that grows at its end.
class McapBytes {
 public:
  template <std::unsigned_integral Number>
  McapBytes& Add(Number number) {
    for (size_t i = 0; i < sizeof(Number); ++i) {
      bytes_.push_back(static_cast<char>(static_cast<uint64_t>(number) >> (8 * i)));
    }
    return *this;
  }
  McapBytes& Add(McapOpcode opcode) { return Add(static_cast<uint8_t>(opcode)); }
  // Adds text or bytes, and their length as 32 bits before them.
  McapBytes& Add(absl::string_view text) {
    Add(static_cast<uint32_t>(text.size()));
    return AddRaw(text);
  }
  McapBytes& AddRaw(absl::string_view bytes) {
    bytes_.append(bytes.data(), bytes.size());
    return *this;
  }
  template <typename Key, typename Value>
  McapBytes& Add(const std::map<Key, Value>& map) {
    McapBytes entries;
    for (const auto& [key, value] : map) entries.Add(key).Add(value);
    return Add(entries.view());
  }
  // Adds a whole record.
  McapBytes& AddRecord(McapOpcode opcode, const McapBytes& content) {
    return Add(opcode).Add(uint64_t{content.size()}).AddRaw(content.view());
  }

  absl::string_view view() const { return bytes_; }
  size_t size() const { return bytes_.size(); }
  void Clear() { bytes_.clear(); }

 private:
  std::string bytes_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MCAP_BYTES_H_
