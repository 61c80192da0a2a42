#include "map_store/rocks/log_file_check.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "slam/util/checksum.h"

namespace corbslam::map_store {
namespace {

// A log is blocks of this size; a record is one or more fragments, none of which crosses the end of
// a block: checksum (4 bytes), length (2), type (1), in logs that are used again the log's number
// (4), and as many bytes as the length says. What is left of a block that has no room for that is
// zeros.
constexpr uint64_t kBlockBytes = 32 << 10;
constexpr uint64_t kHeaderBytes = 7;
constexpr uint64_t kLogNumberBytes = 4;
constexpr uint64_t kPieceBlocks = 8;
enum Type : unsigned { kFull = 1, kFirst, kMiddle, kLast, kRecyclableFull, kRecyclableLast = 8 };
// Other types say something of the log itself, in one fragment.
constexpr unsigned kLastType = 11;

uint64_t ReadLittle(std::string_view bytes, size_t at, size_t count) {
  uint64_t value = 0;
  for (size_t i = count; i-- > 0;) value = value << 8 | static_cast<uint8_t>(bytes[at + i]);
  return value;
}

// RocksDB turns checksums that it stores, so that they are no checksums of themselves.
uint32_t Mask(uint32_t crc) { return ((crc >> 15) | (crc << 17)) + 0xa282ead8u; }

class LogReader {
 public:
  // Takes one block, the last one if `is_last`; returns false at the first thing that is wrong.
  bool Take(std::string_view block, bool is_last) {
    uint64_t at = 0;
    while (block.size() - at >= kHeaderBytes) {
      const uint64_t left = block.size() - at;
      const uint64_t length = ReadLittle(block, at + 4, 2);
      const auto type = static_cast<unsigned>(static_cast<uint8_t>(block[at + 6]));
      const bool is_recyclable = type >= kRecyclableFull && type <= kRecyclableLast;
      const uint64_t header = kHeaderBytes + (is_recyclable ? kLogNumberBytes : 0);
      if (type == 0 || type > kLastType) return Stop(at, "a type that there is not", is_last);
      if (header + length > left) {
        const bool ends_early = is_last && at + header + length <= kBlockBytes;
        return Stop(at, ends_early ? "the file ends within it" : "a wrong length", ends_early);
      }
      const absl::string_view summed(&block[at + 6], header - 6 + length);
      if (Mask(ExtendCrc32c(0, summed)) != ReadLittle(block, at, 4)) {
        return Stop(at, "its checksum does not match",
                    is_last && at + header + length == block.size());
      }
      const unsigned plain = is_recyclable ? type - kLast : type;
      if (!TakeFragment(plain, block.substr(at + header, length))) {
        return Stop(at, "a fragment that fits no record", false);
      }
      at += header + length;
      if (!in_record_) check_.intact_bytes = begin_ + at;
    }
    if (is_last && in_record_) return Stop(block.size(), "the file ends within it", true);
    const bool is_full_block = block.size() == kBlockBytes;
    if (is_last && !is_full_block && at < block.size()) {
      return Stop(at, "the file ends within it", true);
    }
    if (!in_record_) check_.intact_bytes = begin_ + block.size();
    begin_ += block.size();
    return true;
  }
  LogFileCheck& check() { return check_; }

 private:
  bool Stop(uint64_t at, const char* why, bool may_be_torn) {
    check_.problem = absl::StrCat("the record at ", check_.intact_bytes, " is none: at ",
                                  begin_ + at, " is ", why);
    check_.may_be_torn = may_be_torn;
    return false;
  }
  bool TakeFragment(unsigned type, std::string_view bytes) {
    if (type > kLast) return !in_record_;
    const bool begins = type == kFull || type == kFirst;
    if (begins == in_record_) return false;
    in_record_ = type == kFirst || type == kMiddle;
    if (begins) {
      // A write batch begins with its sequence number and the count of what is in it.
      record_ends_ = bytes.size() < 12 ? 0 : ReadLittle(bytes, 0, 8) + ReadLittle(bytes, 8, 4);
    }
    if (!in_record_ && record_ends_ > 0) check_.last_sequence = record_ends_ - 1;
    return true;
  }

  LogFileCheck check_;
  uint64_t begin_ = 0;
  bool in_record_ = false;
  uint64_t record_ends_ = 0;
};

}  // namespace

absl::StatusOr<LogFileCheck> CheckLogFile(const std::string& path, uint64_t end,
                                          const ReadPace& goes_on) {
  std::error_code error;
  const uint64_t size = std::filesystem::file_size(path, error);
  if (error == std::errc::no_such_file_or_directory) {
    return absl::NotFoundError(path + " is lost");
  }
  std::ifstream file(path, std::ios::binary);
  if (error || !file) return absl::DataLossError(path + " can't be read");
  const uint64_t bytes = std::min(size, end);
  LogReader reader;
  std::string block;
  uint64_t since = 0;
  for (uint64_t at = 0; at < bytes; at += block.size()) {
    block.resize(std::min(kBlockBytes, bytes - at));
    if (!file.read(block.data(), static_cast<std::streamsize>(block.size()))) {
      return absl::DataLossError(absl::StrCat(path, " can't be read at ", at));
    }
    reader.check().bytes += block.size();
    since += block.size();
    if (!reader.Take(block, at + block.size() == bytes)) break;
    if (since < kPieceBlocks * kBlockBytes) continue;
    if (!goes_on(since)) return absl::CancelledError(path);
    since = 0;
  }
  if (since > 0 && !goes_on(since)) return absl::CancelledError(path);
  return reader.check();
}

}  // namespace corbslam::map_store
