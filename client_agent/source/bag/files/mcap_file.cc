#include "client_agent/source/bag/files/mcap_file.h"

#include <zlib.h>

#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/source/bag/files/bag_notes.h"
#include "client_agent/source/bag/files/byte_cursor.h"
#include "client_agent/source/bag/files/chunk_store.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

enum McapOp : uint8_t {
  kMcapFooter = 0x02,
  kMcapSchema = 0x03,
  kMcapChannel = 0x04,
  kMcapMessage = 0x05,
  kMcapChunk = 0x06,
  kMcapDataEnd = 0x0F,
};
constexpr uint64_t kMcapRecordHead = 9;    // Operation and length.
constexpr uint64_t kMcapMessageHead = 22;  // Channel, number and two times.
constexpr uint64_t kMcapChunkHead = 64;    // All but the records, with a compression's name.
constexpr uint64_t kMostDescription = uint64_t{16} << 20;

// The bytes that are walked through: the file's, or those of an unpacked chunk.
struct McapWindow {
  const BagBytes& bytes;
  uint64_t begin = 0;
  uint64_t end = 0;
  uint32_t chunk = BagPlace::kNoChunk;
  bool in_chunk = false;
};

struct McapRecord {
  uint8_t op = 0;
  uint64_t offset = 0;  // Of what follows the record's head.
  uint64_t size = 0;
  absl::string_view head;  // Its first bytes.
};

class McapFile : public BagFile {
 public:
  explicit McapFile(std::unique_ptr<const BagBytes> file) : store_(std::move(file)) {}

  absl::string_view format() const override { return "MCAP"; }
  void Scan(Use use) override {
    Walk({store_.file(), kMcapMagic.size(), store_.file().size()}, use);
    if (closed_) return;
    notes_.Add(absl::StrCat(store_.file().name(),
                            ": was not closed and has no index: read through to its last whole "
                            "record"));
  }
  const std::vector<BagChannel>& channels() const override { return channels_; }
  const std::vector<std::string>& notes() const override { return notes_.all(); }
  absl::StatusOr<std::string> Read(const BagPlace& place) const override {
    return store_.Read(place);
  }

 private:
  // Returns false where nothing that follows is to be read.
  bool Take(const McapWindow& window, const McapRecord& record, Use use);
  void Walk(const McapWindow& window, Use use);
  absl::Status TakeSchema(const McapWindow& window, const McapRecord& record);
  absl::Status TakeChannel(const McapWindow& window, const McapRecord& record);
  absl::Status TakeMessage(const McapWindow& window, const McapRecord& record, Use use);
  absl::Status TakeChunk(const McapRecord& record, Use use);
  absl::Status CheckSum(const McapWindow& chunk, uint32_t sum) const;

  ChunkStore store_;
  std::map<uint16_t, std::string> types_;
  std::map<uint16_t, size_t> numbers_;  // Of channels, by the file's ids.
  std::vector<BagChannel> channels_;
  BagNotes notes_;
  bool closed_ = false;
};

void McapFile::Walk(const McapWindow& window, Use use) {
  uint64_t at = window.begin;
  while (at < window.end) {
    const auto bytes =
        window.bytes.ReadUpTo(at, kMcapRecordHead + kMcapMessageHead + kBagHeadBytes);
    if (!bytes.ok()) return notes_.Add(bytes.status());
    ByteCursor cursor(*bytes);
    McapRecord record;
    record.op = cursor.Take<uint8_t>();
    record.size = cursor.Take<uint64_t>();
    record.offset = at + kMcapRecordHead;
    if (!cursor.ok() || record.size > window.end - record.offset) {
      if (window.in_chunk || closed_) {
        notes_.Add(window.bytes.ErrorAt(at, "a record is longer than what holds it"));
      } else {
        notes_.Add(window.bytes.ErrorAt(at, "the file is cut short within a record"));
      }
      return;
    }
    record.head = cursor.rest().substr(0, record.size);
    if (!Take(window, record, use)) return;
    at = record.offset + record.size;
  }
}

bool McapFile::Take(const McapWindow& window, const McapRecord& record, Use use) {
  absl::Status status;
  switch (record.op) {
    case kMcapSchema:
      status = TakeSchema(window, record);
      break;
    case kMcapChannel:
      status = TakeChannel(window, record);
      break;
    case kMcapMessage:
      status = TakeMessage(window, record, use);
      break;
    case kMcapChunk:
      status = window.in_chunk ? window.bytes.ErrorAt(record.offset, "a chunk in a chunk")
                               : TakeChunk(record, use);
      break;
    case kMcapDataEnd:
    case kMcapFooter:
      closed_ = closed_ || !window.in_chunk;
      return false;
    default:
      break;  // Indexes, attachments and what later versions add.
  }
  if (!status.ok()) notes_.Add(status);
  return true;
}

absl::Status McapFile::TakeSchema(const McapWindow& window, const McapRecord& record) {
  if (record.size > kMostDescription) {
    return window.bytes.ErrorAt(record.offset, absl::StrCat("a schema of ", record.size, " bytes"));
  }
  ASSIGN_OR_RETURN(const std::string bytes,
                   window.bytes.Read(record.offset, record.size, "a schema"));
  ByteCursor cursor(bytes);
  const auto id = cursor.Take<uint16_t>();
  const absl::string_view name = cursor.TakeText();
  if (!cursor.ok()) return window.bytes.ErrorAt(record.offset, "a schema is cut short");
  types_.insert_or_assign(id, PlainTypeName(name));
  return absl::OkStatus();
}

// Returns the value of a map of texts, or "".
std::string McapValue(absl::string_view map, absl::string_view key) {
  ByteCursor cursor(map);
  while (!cursor.AtEnd()) {
    const absl::string_view name = cursor.TakeText();
    const absl::string_view value = cursor.TakeText();
    if (cursor.ok() && name == key) return std::string(value);
  }
  return "";
}

absl::Status McapFile::TakeChannel(const McapWindow& window, const McapRecord& record) {
  if (record.size > kMostDescription) {
    return window.bytes.ErrorAt(record.offset,
                                absl::StrCat("a channel of ", record.size, " bytes"));
  }
  ASSIGN_OR_RETURN(const std::string bytes,
                   window.bytes.Read(record.offset, record.size, "a channel"));
  ByteCursor cursor(bytes);
  const auto id = cursor.Take<uint16_t>();
  const auto schema = cursor.Take<uint16_t>();
  BagChannel channel;
  channel.topic = CleanName(cursor.TakeText());
  channel.encoding_name = CleanName(cursor.TakeText());
  if (!cursor.ok()) return window.bytes.ErrorAt(record.offset, "a channel is cut short");
  channel.publisher = CleanName(McapValue(cursor.TakeText(), "callerid"));
  channel.encoding = EncodingOfName(channel.encoding_name);
  if (const auto type = types_.find(schema); type != types_.end()) channel.type = type->second;
  if (numbers_.emplace(id, channels_.size()).second) channels_.push_back(std::move(channel));
  return absl::OkStatus();
}

absl::Status McapFile::TakeMessage(const McapWindow& window, const McapRecord& record, Use use) {
  ByteCursor cursor(record.head);
  const auto id = cursor.Take<uint16_t>();
  cursor.Take<uint32_t>();
  const auto recorded_ns = cursor.Take<uint64_t>();
  cursor.Take<uint64_t>();
  if (!cursor.ok() || record.size - kMcapMessageHead > kMostBagBytes) {
    return window.bytes.ErrorAt(record.offset,
                                absl::StrCat("a message of ", record.size, " bytes"));
  }
  const auto channel = numbers_.find(id);
  if (channel == numbers_.end()) {
    return window.bytes.ErrorAt(record.offset,
                                absl::StrCat("a message of channel ", id, ", which is not there"));
  }
  use({channel->second,
       static_cast<int64_t>(recorded_ns),
       {window.chunk, static_cast<uint32_t>(record.size - kMcapMessageHead),
        record.offset + kMcapMessageHead},
       cursor.rest()});
  return absl::OkStatus();
}

absl::Status McapFile::CheckSum(const McapWindow& chunk, uint32_t sum) const {
  if (sum == 0) return absl::OkStatus();  // None was made.
  ASSIGN_OR_RETURN(const std::string bytes,
                   chunk.bytes.Read(chunk.begin, chunk.end - chunk.begin, "a chunk"));
  const uLong found =
      crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size()));
  if (found == sum) return absl::OkStatus();
  return chunk.bytes.ErrorAt(chunk.begin, "the checksum is another one: this chunk is damaged");
}

absl::Status McapFile::TakeChunk(const McapRecord& record, Use use) {
  const BagBytes& file = store_.file();
  const std::string kept(record.head.substr(0, kMcapChunkHead));
  ByteCursor cursor(kept);
  cursor.Take<uint64_t>();
  cursor.Take<uint64_t>();
  PackedChunk chunk;
  chunk.size = cursor.Take<uint64_t>();
  const auto sum = cursor.Take<uint32_t>();
  chunk.compression = CleanName(cursor.TakeText());
  chunk.packed_size = cursor.Take<uint64_t>();
  const uint64_t head = kept.size() - cursor.rest().size();
  if (!cursor.ok() || chunk.packed_size > record.size - head) {
    return file.ErrorAt(record.offset, "a chunk's head is damaged");
  }
  chunk.offset = record.offset + head;
  if (chunk.compression.empty()) {
    Walk({file, chunk.offset, chunk.offset + chunk.packed_size, BagPlace::kNoChunk, true}, use);
    return absl::OkStatus();
  }
  const uint32_t number = store_.Add(std::move(chunk));
  ASSIGN_OR_RETURN(const std::shared_ptr<const BagBytes> bytes, store_.Chunk(number));
  const McapWindow window{*bytes, 0, bytes->size(), number, true};
  RETURN_IF_ERROR(CheckSum(window, sum));
  Walk(window, use);
  return absl::OkStatus();
}

}  // namespace

std::unique_ptr<BagFile> MakeMcapFile(std::unique_ptr<const BagBytes> file) {
  return std::make_unique<McapFile>(std::move(file));
}

}  // namespace corbslam::client_agent
