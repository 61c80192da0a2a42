#include "client_agent/source/bag/messages/ros_wire.h"

#include "absl/strings/str_format.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kCdrHeader = 4;

}  // namespace

absl::StatusOr<RosWire> RosWire::Open(BagEncoding encoding, absl::string_view bytes) {
  if (encoding == BagEncoding::kRos1) return RosWire(bytes, 0, 1, false);
  if (encoding != BagEncoding::kCdr) {
    return absl::InvalidArgumentError("neither ROS 1's serialisation nor CDR");
  }
  if (bytes.size() < kCdrHeader) {
    return absl::InvalidArgumentError("CDR of fewer than 4 bytes");
  }
  const auto kind = static_cast<uint8_t>(bytes[1]);
  // 0 and 1: CDR, 6 and 7: version 2, which aligns to 4 at most. Odd ones are little-endian.
  const bool is_known = bytes[0] == 0 && (kind == 0 || kind == 1 || kind == 6 || kind == 7);
  if (is_known) return RosWire(bytes, kCdrHeader, kind < 2 ? 8 : 4, kind % 2 == 0);
  return absl::InvalidArgumentError(absl::StrFormat(
      "CDR's representation is 0x%02x%02x, known are 0x0000, 0x0001, 0x0006 and 0x0007",
      static_cast<uint8_t>(bytes[0]), kind));
}

absl::string_view RosWire::TakeBytes(size_t count, const char* field) {
  if (!ok()) return {};
  if (at_ > bytes_.size() || count > bytes_.size() - at_) {
    missing_ = field;
    return {};
  }
  const absl::string_view taken = bytes_.substr(at_, count);
  at_ += count;
  return taken;
}

absl::string_view RosWire::TakeText(const char* field) {
  absl::string_view text = TakeByteList(field);
  if (!is_ros1() && !text.empty() && text.back() == '\0') text.remove_suffix(1);
  return text;
}

std::vector<double> RosWire::TakeDoubles(const char* field) {
  const auto count = Take<uint32_t>(field);
  if (!ok() || count > (bytes_.size() - at_) / sizeof(double)) {
    if (ok()) missing_ = field;
    return {};
  }
  std::vector<double> numbers(count);
  TakeArray(numbers, field);
  return numbers;
}

}  // namespace corbslam::client_agent
