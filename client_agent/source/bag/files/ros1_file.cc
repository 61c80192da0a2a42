#include "client_agent/source/bag/files/ros1_file.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/source/bag/files/bag_notes.h"
#include "client_agent/source/bag/files/byte_cursor.h"
#include "client_agent/source/bag/files/chunk_store.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

enum Ros1Op : uint8_t {
  kRos1Message = 2,
  kRos1BagHeader = 3,
  kRos1Chunk = 5,
  kRos1Connection = 7,
};
// Headers hold a few short fields; what describes a message's type lies in a connection's data.
constexpr uint32_t kMostRos1Header = uint32_t{1} << 20;
constexpr uint32_t kMostRos1Description = uint32_t{16} << 20;
constexpr uint64_t kRos1FirstBytes = 256;
constexpr int64_t kNsOfSecond = 1'000'000'000;

using Ros1Fields = std::map<std::string, std::string, std::less<>>;

// Returns nullopt where a field is no "name=value".
std::optional<Ros1Fields> ParseRos1Fields(absl::string_view bytes) {
  ByteCursor cursor(bytes);
  Ros1Fields fields;
  while (!cursor.AtEnd()) {
    const absl::string_view field = cursor.TakeText();
    const size_t equal = field.find('=');
    if (!cursor.ok() || equal == absl::string_view::npos) return std::nullopt;
    fields.emplace(field.substr(0, equal), field.substr(equal + 1));
  }
  if (!cursor.ok()) return std::nullopt;
  return fields;
}

// Returns the field's number; nullopt where it is not there, or of another size.
template <typename Number>
std::optional<Number> Ros1Number(const Ros1Fields& fields, absl::string_view name) {
  const auto field = fields.find(name);
  if (field == fields.end() || field->second.size() != sizeof(Number)) return std::nullopt;
  return ByteCursor(field->second).Take<Number>();
}

std::string Ros1Text(const Ros1Fields& fields, absl::string_view name) {
  const auto field = fields.find(name);
  return field == fields.end() ? "" : CleanName(field->second);
}

struct Ros1Window {
  const BagBytes& bytes;
  uint64_t begin = 0;
  uint64_t end = 0;
  uint32_t chunk = BagPlace::kNoChunk;
  bool in_chunk = false;
};

struct Ros1Record {
  Ros1Fields header;
  uint64_t begin = 0;
  uint64_t data = 0;  // Where its data begins.
  uint32_t size = 0;  // Of its data.
  uint64_t End() const { return data + size; }
};

class Ros1File : public BagFile {
 public:
  explicit Ros1File(std::unique_ptr<const BagBytes> file) : store_(std::move(file)) {}

  absl::string_view format() const override { return "ROS 1 bag"; }
  void Scan(Use use) override {
    Walk({store_.file(), kRos1Magic.size(), store_.file().size()}, use);
    if (closed_) return;
    notes_.Add(absl::StrCat(store_.file().name(),
                            ": was not closed and has no index: read through to its last whole "
                            "chunk"));
  }
  const std::vector<BagChannel>& channels() const override { return channels_; }
  const std::vector<std::string>& notes() const override { return notes_.all(); }
  absl::StatusOr<std::string> Read(const BagPlace& place) const override {
    return store_.Read(place);
  }

 private:
  absl::StatusOr<Ros1Record> ReadRecord(const Ros1Window& window, uint64_t at) const;
  void Walk(const Ros1Window& window, Use use);
  absl::Status Take(const Ros1Window& window, const Ros1Record& record, Use use);
  absl::Status TakeBagHeader(const Ros1Window& window, const Ros1Record& record);
  absl::Status TakeConnection(const Ros1Window& window, const Ros1Record& record);
  absl::Status TakeMessage(const Ros1Window& window, const Ros1Record& record, Use use);
  absl::Status TakeChunk(const Ros1Record& record, Use use);

  ChunkStore store_;
  std::map<uint32_t, size_t> numbers_;  // Of channels, by the file's connections.
  std::vector<BagChannel> channels_;
  BagNotes notes_;
  bool closed_ = false;
};

absl::StatusOr<Ros1Record> Ros1File::ReadRecord(const Ros1Window& window, uint64_t at) const {
  const BagBytes& bytes = window.bytes;
  ASSIGN_OR_RETURN(std::string first, bytes.ReadUpTo(at, kRos1FirstBytes));
  const auto header_size = ByteCursor(first).Take<uint32_t>();
  const uint64_t left = window.end - at;
  if (left < 8 || header_size > left - 8) return bytes.ErrorAt(at, "a record is cut short");
  if (header_size > kMostRos1Header) {
    return bytes.ErrorAt(at, absl::StrCat("a record's header of ", header_size, " bytes"));
  }
  if (first.size() < uint64_t{header_size} + 8) {
    ASSIGN_OR_RETURN(first, bytes.Read(at, uint64_t{header_size} + 8, "a record's header"));
  }
  ByteCursor cursor(first);
  std::optional<Ros1Fields> header = ParseRos1Fields(cursor.TakeText());
  if (!header.has_value()) return bytes.ErrorAt(at, "a record's header holds no fields");
  Ros1Record record{*std::move(header), at, at + 8 + header_size, cursor.Take<uint32_t>()};
  if (record.size <= window.end - record.data) return record;
  return bytes.ErrorAt(at, absl::StrCat("a record is cut short: ", record.size, " bytes of data, ",
                                        window.end - record.data, " are there"));
}

void Ros1File::Walk(const Ros1Window& window, Use use) {
  uint64_t at = window.begin;
  while (at < window.end) {
    const absl::StatusOr<Ros1Record> record = ReadRecord(window, at);
    if (!record.ok()) return notes_.Add(record.status());
    if (const absl::Status taken = Take(window, *record, use); !taken.ok()) notes_.Add(taken);
    at = record->End();
  }
}

absl::Status Ros1File::Take(const Ros1Window& window, const Ros1Record& record, Use use) {
  const std::optional<uint8_t> op = Ros1Number<uint8_t>(record.header, "op");
  if (!op.has_value()) return window.bytes.ErrorAt(record.begin, "a record without op");
  switch (*op) {
    case kRos1BagHeader:
      return TakeBagHeader(window, record);
    case kRos1Connection:
      return TakeConnection(window, record);
    case kRos1Message:
      return TakeMessage(window, record, use);
    case kRos1Chunk:
      if (window.in_chunk) return window.bytes.ErrorAt(record.begin, "a chunk in a chunk");
      return TakeChunk(record, use);
    default:
      return absl::OkStatus();  // Indexes.
  }
}

absl::Status Ros1File::TakeBagHeader(const Ros1Window& window, const Ros1Record& record) {
  closed_ = Ros1Number<uint64_t>(record.header, "index_pos").value_or(0) != 0;
  const std::string encryptor = Ros1Text(record.header, "encryptor");
  if (encryptor.empty()) return absl::OkStatus();
  return window.bytes.ErrorAt(
      record.begin, absl::StrCat("encrypted by ", encryptor, ": decrypt it with rosbag first"));
}

absl::Status Ros1File::TakeConnection(const Ros1Window& window, const Ros1Record& record) {
  const std::optional<uint32_t> id = Ros1Number<uint32_t>(record.header, "conn");
  if (!id.has_value()) return window.bytes.ErrorAt(record.begin, "a connection without conn");
  if (numbers_.contains(*id)) return absl::OkStatus();  // They stand in the index again.
  if (record.size > kMostRos1Description) {
    return window.bytes.ErrorAt(record.begin,
                                absl::StrCat("a connection of ", record.size, " bytes"));
  }
  ASSIGN_OR_RETURN(const std::string data,
                   window.bytes.Read(record.data, record.size, "a connection"));
  const std::optional<Ros1Fields> fields = ParseRos1Fields(data);
  if (!fields.has_value()) return window.bytes.ErrorAt(record.data, "a connection holds no fields");
  numbers_.emplace(*id, channels_.size());
  channels_.push_back({Ros1Text(record.header, "topic"), PlainTypeName(Ros1Text(*fields, "type")),
                       "ros1", BagEncoding::kRos1, Ros1Text(*fields, "callerid")});
  return absl::OkStatus();
}

absl::Status Ros1File::TakeMessage(const Ros1Window& window, const Ros1Record& record, Use use) {
  const std::optional<uint32_t> id = Ros1Number<uint32_t>(record.header, "conn");
  const std::optional<uint64_t> time = Ros1Number<uint64_t>(record.header, "time");
  const auto channel = id.has_value() ? numbers_.find(*id) : numbers_.end();
  if (channel == numbers_.end() || !time.has_value()) {
    return window.bytes.ErrorAt(record.begin, "a message without a known conn, or without time");
  }
  if (record.size > kMostBagBytes) {
    return window.bytes.ErrorAt(record.begin, absl::StrCat("a message of ", record.size, " bytes"));
  }
  const auto seconds = static_cast<int64_t>(*time & UINT32_MAX);
  const auto nanoseconds = static_cast<int64_t>(*time >> 32);
  ASSIGN_OR_RETURN(
      const std::string head,
      window.bytes.ReadUpTo(record.data, std::min<uint64_t>(record.size, kBagHeadBytes)));
  use({channel->second,
       seconds * kNsOfSecond + nanoseconds,
       {window.chunk, record.size, record.data},
       head});
  return absl::OkStatus();
}

absl::Status Ros1File::TakeChunk(const Ros1Record& record, Use use) {
  const BagBytes& file = store_.file();
  const std::string compression = Ros1Text(record.header, "compression");
  if (compression == "none") {
    Walk({file, record.data, record.End(), BagPlace::kNoChunk, true}, use);
    return absl::OkStatus();
  }
  const std::optional<uint32_t> size = Ros1Number<uint32_t>(record.header, "size");
  if (!size.has_value()) return file.ErrorAt(record.begin, "a chunk without size");
  const uint32_t number = store_.Add({record.data, record.size, *size, compression});
  ASSIGN_OR_RETURN(const std::shared_ptr<const BagBytes> bytes, store_.Chunk(number));
  Walk({*bytes, 0, bytes->size(), number, true}, use);
  return absl::OkStatus();
}

}  // namespace

std::unique_ptr<BagFile> MakeRos1File(std::unique_ptr<const BagBytes> file) {
  return std::make_unique<Ros1File>(std::move(file));
}

}  // namespace corbslam::client_agent
