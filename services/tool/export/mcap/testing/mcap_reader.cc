#include "services/tool/export/mcap/testing/mcap_reader.h"

#include <cstring>
#include <fstream>
#include <iterator>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "services/tool/export/mcap/mcap_bytes.h"
#include "slam/util/status_macros.h"

namespace corbslam::testing {
namespace {

constexpr absl::string_view kMagic("\x89MCAP\x30\r\n", 8);

// Takes values from the beginning of some bytes; what is not there is 0 and sets `failed`.
struct Cursor {
  absl::string_view rest;
  bool failed = false;

  absl::string_view Raw(uint64_t size) {
    failed = failed || size > rest.size();
    if (failed) return {};
    const absl::string_view taken = rest.substr(0, size);
    rest.remove_prefix(size);
    return taken;
  }
  template <typename Number>
  Number Take() {
    Number number = 0;
    const absl::string_view bytes = Raw(sizeof(Number));
    if (!failed) std::memcpy(&number, bytes.data(), sizeof(Number));
    return number;
  }
  std::string Text() { return std::string(Raw(Take<uint32_t>())); }
};

struct Record {
  int opcode = 0;
  absl::string_view content;
  uint64_t offset = 0;
};

class Reader {
 public:
  explicit Reader(absl::string_view bytes) : bytes_(bytes) {}

  absl::StatusOr<McapFile> Read() {
    if (bytes_.size() < 16 || bytes_.substr(0, 8) != kMagic ||
        bytes_.substr(bytes_.size() - 8) != kMagic) {
      return absl::DataLossError("no magic bytes at both ends");
    }
    Cursor cursor{bytes_.substr(8, bytes_.size() - 16)};
    RETURN_IF_ERROR(ReadRecords(cursor, 8));
    if (!ended_) return absl::DataLossError("no footer at the end");
    if (counted_ != file_.messages.size()) return absl::DataLossError("messages that no index has");
    if (file_.message_count != file_.messages.size()) return absl::DataLossError("wrong counts");
    return std::move(file_);
  }

 private:
  absl::Status ReadRecords(Cursor& cursor, uint64_t offset) {
    while (!cursor.rest.empty()) {
      const size_t before = cursor.rest.size();
      Record record{cursor.Take<uint8_t>(), {}, offset};
      record.content = cursor.Raw(cursor.Take<uint64_t>());
      if (cursor.failed) return absl::DataLossError("a record goes on behind the end");
      RETURN_IF_ERROR(ReadRecord(record));
      offset += before - cursor.rest.size();
    }
    return absl::OkStatus();
  }

  absl::Status ReadRecord(const Record& record) {
    Cursor content{record.content};
    absl::Status status;
    switch (record.opcode) {
      case 0x01:
      case 0x0d:
      case 0x0e:
        return absl::OkStatus();
      case 0x02:
        return ReadFooter(record, content);
      case 0x03:
        ReadSchema(content);
        break;
      case 0x04:
        ReadChannel(content);
        break;
      case 0x05:
        status = ReadMessage(record, content);
        break;
      case 0x06:
        status = ReadChunk(content);
        break;
      case 0x07:
        status = ReadMessageIndex(content);
        break;
      case 0x08:
        status = ReadChunkIndex(content);
        break;
      case 0x0b:
        ReadStatistics(content);
        break;
      case 0x0c:
        ReadMetadata(content);
        break;
      case 0x0f:
        status = CheckCrc(content.Take<uint32_t>(), bytes_.substr(0, record.offset), "data");
        break;
      default:
        return absl::DataLossError(absl::StrCat("opcode ", record.opcode));
    }
    if (content.failed) return absl::DataLossError("a record is too short");
    return status;
  }

  absl::Status CheckCrc(uint32_t crc, absl::string_view data, absl::string_view what) {
    if (services::ExtendMcapCrc(0, data) == crc) return absl::OkStatus();
    return absl::DataLossError(absl::StrCat("the checksum of the ", what, " is wrong"));
  }

  absl::Status ReadFooter(const Record& record, Cursor& content) {
    ended_ = true;
    const auto summary = content.Take<uint64_t>();
    content.Take<uint64_t>();
    const uint64_t covered = record.offset + 9 + 16;
    return CheckCrc(content.Take<uint32_t>(), bytes_.substr(summary, covered - summary), "summary");
  }

  void ReadSchema(Cursor& content) {
    const auto id = content.Take<uint16_t>();
    const std::string name = content.Text();
    content.Text();
    file_.schemas[id] = {name, content.Text()};
  }

  void ReadChannel(Cursor& content) {
    const auto id = content.Take<uint16_t>();
    const auto schema = content.Take<uint16_t>();
    channels_[id] = {content.Text(), file_.schemas[schema].name};
  }

  absl::Status ReadMessage(const Record& record, Cursor& content) {
    const auto channel = channels_.find(content.Take<uint16_t>());
    if (channel == channels_.end()) return absl::DataLossError("a message before its channel");
    content.Take<uint32_t>();
    const auto time_ns = content.Take<uint64_t>();
    content.Take<uint64_t>();
    in_chunk_[record.offset] = {channel->first, time_ns};
    file_.messages.push_back(
        {channel->second.first, channel->second.second, time_ns, std::string(content.rest)});
    return absl::OkStatus();
  }

  absl::Status ReadChunk(Cursor& content) {
    content.Take<uint64_t>();
    content.Take<uint64_t>();
    const auto size = content.Take<uint64_t>();
    const auto crc = content.Take<uint32_t>();
    if (!content.Text().empty()) return absl::DataLossError("compressed");
    if (content.Take<uint64_t>() != size) return absl::DataLossError("two sizes of a chunk");
    const absl::string_view records = content.Raw(size);
    RETURN_IF_ERROR(CheckCrc(crc, records, "chunk"));
    in_chunk_.clear();
    file_.chunk_bytes.push_back(size);
    Cursor cursor{records};
    return ReadRecords(cursor, 0);
  }

  absl::Status ReadMessageIndex(Cursor& content) {
    const auto channel = content.Take<uint16_t>();
    Cursor entries{content.Raw(content.Take<uint32_t>())};
    while (!entries.rest.empty() && !entries.failed) {
      const auto time_ns = entries.Take<uint64_t>();
      const auto message = in_chunk_.find(entries.Take<uint64_t>());
      if (message == in_chunk_.end() || message->second != std::pair(channel, time_ns)) {
        return absl::DataLossError("an index leads to another message");
      }
      ++counted_;
    }
    return absl::OkStatus();
  }

  absl::Status ReadChunkIndex(Cursor& content) {
    content.Take<uint64_t>();
    content.Take<uint64_t>();
    const auto start = content.Take<uint64_t>();
    const auto length = content.Take<uint64_t>();
    Cursor chunk{bytes_.substr(start < bytes_.size() ? start : bytes_.size())};
    if (chunk.Take<uint8_t>() != 0x06 || chunk.Take<uint64_t>() + 9 != length) {
      return absl::DataLossError("an index leads to no chunk");
    }
    return absl::OkStatus();
  }

  void ReadStatistics(Cursor& content) {
    file_.message_count = content.Take<uint64_t>();
    content.Raw(2 + 4 * 4);
    file_.first_ns = content.Take<uint64_t>();
    file_.last_ns = content.Take<uint64_t>();
  }

  void ReadMetadata(Cursor& content) {
    auto& entries = file_.metadata[content.Text()];
    Cursor map{content.Raw(content.Take<uint32_t>())};
    while (!map.rest.empty() && !map.failed) {
      const std::string key = map.Text();
      entries[key] = map.Text();
    }
  }

  const absl::string_view bytes_;
  McapFile file_;
  std::map<uint16_t, std::pair<std::string, std::string>> channels_;  // Topic and schema.
  std::map<uint64_t, std::pair<uint16_t, uint64_t>> in_chunk_;  // Channel and time, by offset.
  uint64_t counted_ = 0;
  bool ended_ = false;
};

}  // namespace

std::vector<McapFile::Message> McapFile::On(const std::string& topic) const {
  std::vector<Message> found;
  for (const Message& message : messages) {
    if (message.topic == topic) found.push_back(message);
  }
  return found;
}

absl::StatusOr<McapFile> ReadMcap(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return absl::NotFoundError(absl::StrCat("can't read ", path));
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  return Reader(bytes).Read();
}

}  // namespace corbslam::testing
