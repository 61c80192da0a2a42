// Takes fields off a message as ROS 1 or ROS 2 (CDR) made it bytes.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_MESSAGES_ROS_WIRE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_MESSAGES_ROS_WIRE_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/source/bag/files/bag_file.h"

namespace corbslam::client_agent {

// ROS 1 packs little-endian fields without gaps. CDR (OMG's DDS-XTypes, 7.4) begins with four bytes
// that say the order of bytes and the version, and aligns each number to its own size, counted from
// behind these; its texts end with a zero that their length counts. Once bytes are missing, ok() is
// false, `missing()` names the first field that is not whole, and what is taken is 0 or empty.
class RosWire {
 public:
  // INVALID_ARGUMENT: not those of a message, or a version of CDR that nobody writes for ROS.
  static absl::StatusOr<RosWire> Open(BagEncoding encoding, absl::string_view bytes);

  bool is_ros1() const { return most_alignment_ == 1; }
  bool ok() const { return missing_ == nullptr; }
  // Returns the field's name, or "".
  absl::string_view missing() const { return missing_ == nullptr ? "" : missing_; }
  size_t offset() const { return at_ + header_; }

  template <typename Number>
  Number Take(const char* field) {
    static_assert(std::is_arithmetic_v<Number>);
    Align(std::min(sizeof(Number), most_alignment_));
    char bytes[sizeof(Number)] = {};
    const absl::string_view taken = TakeBytes(sizeof(Number), field);
    if (ok()) std::memcpy(bytes, taken.data(), sizeof(Number));
    if (swaps_) std::reverse(bytes, bytes + sizeof(Number));
    Number number;
    std::memcpy(&number, bytes, sizeof(Number));
    return number;
  }
  // The bytes stay the message's.
  absl::string_view TakeText(const char* field);
  absl::string_view TakeByteList(const char* field) {
    return TakeBytes(Take<uint32_t>(field), field);
  }
  template <typename Numbers>
  void TakeArray(Numbers& numbers, const char* field) {
    for (auto& number : numbers) number = Take<std::decay_t<decltype(number)>>(field);
  }
  std::vector<double> TakeDoubles(const char* field);

 private:
  RosWire(absl::string_view bytes, size_t header, size_t most_alignment, bool swaps)
      : bytes_(bytes.substr(header)),
        header_(header),
        most_alignment_(most_alignment),
        swaps_(swaps) {}

  absl::string_view TakeBytes(size_t count, const char* field);
  void Align(size_t size) { at_ = (at_ + size - 1) / size * size; }

  absl::string_view bytes_;
  size_t header_ = 0;
  size_t most_alignment_ = 1;
  bool swaps_ = false;  // The message's order of bytes is not this machine's.
  size_t at_ = 0;
  const char* missing_ = nullptr;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_MESSAGES_ROS_WIRE_H_
