// Reads a fuzzer's input as a sequence of messages: two bytes of length, least significant first,
// and the message, again and again.
#ifndef CORBSLAM_TESTS_FUZZ_MESSAGES_H_
#define CORBSLAM_TESTS_FUZZ_MESSAGES_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/strings/string_view.h"

namespace corbslam::tests {

// Takes the next message, which may be cut by the end of the input.
inline absl::string_view TakeMessage(absl::string_view& input) {
  if (input.size() < 2) {
    input = {};
    return {};
  }
  const auto byte = [&](size_t i) { return static_cast<size_t>(static_cast<uint8_t>(input[i])); };
  const size_t length = std::min(byte(0) | byte(1) << 8, input.size() - 2);
  const absl::string_view message = input.substr(2, length);
  input.remove_prefix(2 + length);
  return message;
}

inline void AppendMessage(absl::string_view message, std::string* input) {
  input->push_back(static_cast<char>(message.size() & 0xff));
  input->push_back(static_cast<char>(message.size() >> 8));
  input->append(message.data(), message.size());
}

inline absl::string_view AsText(const uint8_t* data, size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FUZZ_MESSAGES_H_
