// The fields around coded streams: numbers of one to five bytes, and pieces of known lengths.
#ifndef CORBSLAM_SLAM_CODING_BYTE_FIELDS_H_
#define CORBSLAM_SLAM_CODING_BYTE_FIELDS_H_

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace corbslam {

// Appends seven bits a byte, the lowest first; the last byte is below 128.
inline void AppendNumber(uint32_t number, std::string* bytes) {
  for (; number >= 128; number >>= 7) bytes->push_back(static_cast<char>(number | 128));
  bytes->push_back(static_cast<char>(number));
}

// Takes fields off the front. A malformed field makes ok() false for good, and reads as 0 or empty.
class FieldReader {
 public:
  explicit FieldReader(std::string_view bytes) : rest_(bytes) {}

  uint32_t Number() {
    uint64_t number = 0;
    for (int shift = 0; shift < 35; shift += 7) {
      const std::string_view byte = Piece(1);
      if (byte.empty()) return 0;
      number |= (static_cast<uint64_t>(static_cast<uint8_t>(byte[0])) & 127) << shift;
      if (static_cast<uint8_t>(byte[0]) >= 128) continue;
      // A number has one encoding, the shortest.
      const bool is_shortest = shift == 0 || byte[0] != 0;
      if (is_shortest && number <= UINT32_MAX) return static_cast<uint32_t>(number);
      break;
    }
    Fail();
    return 0;
  }
  std::string_view Piece(size_t size) {
    if (size > rest_.size()) {
      Fail();
      return {};
    }
    const std::string_view piece = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return piece;
  }

  bool ok() const { return ok_; }
  size_t left() const { return rest_.size(); }

 private:
  void Fail() {
    ok_ = false;
    rest_ = {};
  }

  std::string_view rest_;
  bool ok_ = true;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CODING_BYTE_FIELDS_H_
