#include "client_agent/spool/spool_segment.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>

#include "absl/strings/str_cat.h"
#include "slam/util/checksum.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they lie");

constexpr absl::string_view kMagic = "CORBSPL";
// Version '1' has batches whose features are not coded.
constexpr char kOldestVersion = '1';
constexpr char kVersion = '3';
constexpr size_t kFixedHeaderBytes = 16;
constexpr size_t kMaxOwnerBytes = 1024;
constexpr uint32_t kClosesFlag = 1;
constexpr uint32_t kSnapshotPartFlag = 2;
constexpr uint32_t kSnapshotEndFlag = 4;
constexpr uint32_t kHeldBackKeyframeFlag = 8;
constexpr uint32_t kHeldBackRestFlag = 16;
constexpr size_t kCrcBytes = 4;
constexpr size_t kRecordHeaderBytes = 28;

template <typename Number>
void AppendNumber(Number value, std::string* bytes) {
  const size_t size = bytes->size();
  bytes->resize(size + sizeof(Number));
  std::memcpy(bytes->data() + size, &value, sizeof(Number));
}

template <typename Number>
Number ReadNumber(absl::string_view bytes, size_t offset) {
  Number value;
  std::memcpy(&value, bytes.data() + offset, sizeof(Number));
  return value;
}

uint32_t FlagOf(SpoolRecord::Kind kind) {
  switch (kind) {
    case SpoolRecord::Kind::kBatch:
      return 0;
    case SpoolRecord::Kind::kSnapshotPart:
      return kSnapshotPartFlag;
    case SpoolRecord::Kind::kSnapshotEnd:
      return kSnapshotPartFlag | kSnapshotEndFlag;
    case SpoolRecord::Kind::kHeldBackKeyframe:
      return kHeldBackKeyframeFlag;
    case SpoolRecord::Kind::kHeldBackRest:
      return kHeldBackRestFlag;
  }
  return 0;
}

uint32_t FlagsOf(const SpoolRecord& record) {
  return FlagOf(record.kind) | (record.closes_local_map ? kClosesFlag : 0);
}

void TakeFlags(uint32_t flags, SpoolRecord& record) {
  using Kind = SpoolRecord::Kind;
  record.closes_local_map = (flags & kClosesFlag) != 0;
  for (const Kind kind :
       {Kind::kSnapshotEnd, Kind::kSnapshotPart, Kind::kHeldBackKeyframe, Kind::kHeldBackRest}) {
    if ((flags & ~kClosesFlag) == FlagOf(kind)) record.kind = kind;
  }
}

absl::Status Foreign(const std::string& name, absl::string_view why) {
  return absl::FailedPreconditionError(absl::StrCat("spool file ", name, " ", why));
}

// Returns where the records begin; none where the header itself is torn.
absl::StatusOr<std::optional<uint64_t>> CheckHeader(SpoolFiles& files, const std::string& name,
                                                    absl::string_view owner) {
  ASSIGN_OR_RETURN(const std::string header,
                   files.Read(name, 0, kFixedHeaderBytes + kMaxOwnerBytes));
  const size_t magic_bytes = std::min(header.size(), kMagic.size());
  // After a loss of power a file may have its length and zeros where nothing was synced yet.
  if (header.find_first_not_of('\0') == std::string::npos) return std::nullopt;
  if (header.substr(0, magic_bytes) != kMagic.substr(0, magic_bytes)) {
    return Foreign(name, "is no spool file");
  }
  if (header.size() > kMagic.size() &&
      (header[kMagic.size()] < kOldestVersion || header[kMagic.size()] > kVersion)) {
    return Foreign(name, absl::StrCat("is of version '", header.substr(kMagic.size(), 1),
                                      "'; this program reads '", std::string(1, kOldestVersion),
                                      "' to '", std::string(1, kVersion), "'"));
  }
  if (header.size() < kFixedHeaderBytes) return std::nullopt;
  const auto owner_bytes = ReadNumber<uint32_t>(header, 8);
  if (owner_bytes > header.size() - kFixedHeaderBytes) return std::nullopt;
  const absl::string_view found = absl::string_view(header).substr(kFixedHeaderBytes, owner_bytes);
  if (ExtendCrc32c(0, found) != ReadNumber<uint32_t>(header, 12)) return std::nullopt;
  if (found != owner) {
    return Foreign(name, absl::StrCat("belongs to ", found, ", not to ", owner));
  }
  return kFixedHeaderBytes + owner_bytes;
}

bool IsIntact(absl::string_view bytes, const SpoolRecord& record) {
  return bytes.size() == record.bytes && bytes.size() >= kRecordHeaderBytes &&
         ExtendCrc32c(0, bytes.substr(kCrcBytes)) == ReadNumber<uint32_t>(bytes, 0);
}

// Returns none where no whole record is there.
absl::StatusOr<std::optional<SpoolRecord>> ReadRecord(SpoolFiles& files, const std::string& name,
                                                      uint64_t offset, uint64_t size) {
  if (size - offset < kRecordHeaderBytes) return std::nullopt;
  ASSIGN_OR_RETURN(const std::string header, files.Read(name, offset, kRecordHeaderBytes));
  if (header.size() < kRecordHeaderBytes) return std::nullopt;
  const auto payload_bytes = ReadNumber<uint32_t>(header, 4);
  const bool fits =
      payload_bytes <= kMaxSpoolPayloadBytes && payload_bytes <= size - offset - kRecordHeaderBytes;
  if (!fits) return std::nullopt;
  SpoolRecord record;
  TakeFlags(ReadNumber<uint32_t>(header, 8), record);
  record.local_map = {ReadNumber<uint64_t>(header, 12)};
  record.number = ReadNumber<uint64_t>(header, 20);
  record.offset = offset;
  record.bytes = static_cast<uint32_t>(kRecordHeaderBytes) + payload_bytes;
  // A record that can't be read now is no torn tail.
  ASSIGN_OR_RETURN(const std::string bytes, files.Read(name, offset, record.bytes));
  if (!IsIntact(bytes, record)) return std::nullopt;
  if (!record.local_map.IsValid() || record.number == 0) return std::nullopt;
  return record;
}

}  // namespace

std::string EncodeSegmentHeader(absl::string_view owner) {
  std::string bytes = absl::StrCat(kMagic, std::string(1, kVersion));
  AppendNumber(static_cast<uint32_t>(owner.size()), &bytes);
  AppendNumber(ExtendCrc32c(0, owner), &bytes);
  absl::StrAppend(&bytes, owner);
  return bytes;
}

std::string EncodeSpoolRecord(const SpoolRecord& record, absl::string_view payload) {
  std::string checked;
  checked.reserve(kRecordHeaderBytes + payload.size());
  AppendNumber(static_cast<uint32_t>(payload.size()), &checked);
  AppendNumber(FlagsOf(record), &checked);
  AppendNumber(record.local_map.value, &checked);
  AppendNumber(record.number, &checked);
  absl::StrAppend(&checked, payload);
  std::string bytes;
  AppendNumber(ExtendCrc32c(0, checked), &bytes);
  absl::StrAppend(&bytes, checked);
  return bytes;
}

absl::StatusOr<SegmentContents> ScanSegment(SpoolFiles& files, const std::string& name,
                                            absl::string_view owner) {
  SegmentContents contents;
  ASSIGN_OR_RETURN(const uint64_t size, files.Size(name));
  ASSIGN_OR_RETURN(const std::optional<uint64_t> begin, CheckHeader(files, name, owner));
  uint64_t offset = begin.value_or(0);
  while (begin.has_value() && offset < size) {
    ASSIGN_OR_RETURN(const std::optional<SpoolRecord> record,
                     ReadRecord(files, name, offset, size));
    if (!record.has_value()) break;
    contents.records.push_back(*record);
    offset += record->bytes;
  }
  contents.torn_bytes = size - offset;
  return contents;
}

absl::StatusOr<std::string> ReadSpoolPayload(SpoolFiles& files, const std::string& name,
                                             const SpoolRecord& record) {
  ASSIGN_OR_RETURN(const std::string bytes, files.Read(name, record.offset, record.bytes));
  if (!IsIntact(bytes, record)) {
    return absl::DataLossError(absl::StrCat("spool file ", name, ": batch ", record.number,
                                            " of local map ", ToString(record.local_map),
                                            " is not as it was written"));
  }
  return bytes.substr(kRecordHeaderBytes);
}

}  // namespace corbslam::client_agent
