// Takes little-endian values off the front of bytes that nobody has checked.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BYTE_CURSOR_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BYTE_CURSOR_H_

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "absl/strings/string_view.h"

namespace corbslam::client_agent {

// Once bytes are missing, ok() is false and everything taken is 0 or empty.
class ByteCursor {
 public:
  explicit ByteCursor(absl::string_view bytes) : rest_(bytes) {}

  bool ok() const { return ok_; }
  bool AtEnd() const { return !ok_ || rest_.empty(); }
  absl::string_view rest() const { return rest_; }

  template <typename Number>
  Number Take() {
    static_assert(std::is_arithmetic_v<Number> && std::endian::native == std::endian::little);
    Number number{};
    const absl::string_view bytes = TakeBytes(sizeof(Number));
    if (ok_) std::memcpy(&number, bytes.data(), sizeof(Number));
    return number;
  }
  absl::string_view TakeBytes(size_t count) {
    ok_ = ok_ && count <= rest_.size();
    if (!ok_) return {};
    const absl::string_view bytes = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return bytes;
  }
  // Takes a length of 32 bits and as many bytes.
  absl::string_view TakeText() { return TakeBytes(Take<uint32_t>()); }

 private:
  absl::string_view rest_;
  bool ok_ = true;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BYTE_CURSOR_H_
