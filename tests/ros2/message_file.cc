#include "tests/ros2/message_file.h"

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"

namespace corbslam::tests {

absl::StatusOr<std::vector<CdrMessage>> ReadMessages(const std::string& file) {
  std::ifstream bytes(file, std::ios::binary);
  std::ifstream lines(file + ".jsonl");
  std::vector<CdrMessage> messages;
  for (std::string text; std::getline(lines, text);) {
    const auto line = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
    if (line.is_discarded() || !line.contains("topic") || !line.contains("size")) {
      return absl::InvalidArgumentError(
          absl::StrCat(file, ".jsonl: line ", messages.size() + 1, " is none of a message"));
    }
    CdrMessage message{line["topic"], line["type"],
                       std::strtoll(line["time_ns"].get<std::string>().c_str(), nullptr, 10), ""};
    message.bytes.resize(line["size"]);
    bytes.seekg(line["offset"].get<int64_t>());
    bytes.read(message.bytes.data(), static_cast<std::streamsize>(message.bytes.size()));
    if (!bytes) return absl::InvalidArgumentError(absl::StrCat(file, ": is cut short"));
    messages.push_back(std::move(message));
  }
  if (messages.empty()) return absl::InvalidArgumentError(absl::StrCat(file, ": no messages"));
  return messages;
}

void MessageFile::Add(const CdrMessage& message) {
  lines_ << nlohmann::json{{"topic", message.topic},
                           {"type", message.type},
                           {"time_ns", absl::StrCat(message.time_ns)},
                           {"offset", at_},
                           {"size", message.bytes.size()}}
                .dump()
         << "\n"
         << std::flush;
  bytes_ << message.bytes << std::flush;
  at_ += message.bytes.size();
}

std::string DdsTypeOf(const std::string& type) {
  // "a/msg/B" is a::msg::dds_::B_.
  const size_t slash = type.rfind('/');
  return absl::StrCat(absl::StrReplaceAll(type.substr(0, slash), {{"/", "::"}}),
                      "::dds_::", type.substr(slash + 1), "_");
}

}  // namespace corbslam::tests
