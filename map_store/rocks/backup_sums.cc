#include "map_store/rocks/backup_sums.h"

#include <cerrno>
#include <cstddef>
#include <fstream>
#include <system_error>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "slam/util/checksum.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

constexpr size_t kReadBytes = 256 << 10;

}  // namespace

bool SummedFile::is_shared() const { return absl::StartsWith(name, "shared_checksum/"); }

absl::StatusOr<std::vector<SummedFile>> ReadBackupSums(const std::string& folder, uint32_t number) {
  const std::string path = absl::StrCat(folder, "/meta/", number);
  std::ifstream meta(path);
  if (!meta) return absl::NotFoundError(absl::StrCat("there is no backup ", path));
  std::vector<SummedFile> files;
  uint64_t count = 0;
  bool has_count = false;
  for (std::string line; std::getline(meta, line);) {
    const std::vector<absl::string_view> fields = absl::StrSplit(line, ' ');
    SummedFile file;
    if (fields.size() == 3 && fields[1] == "crc32" && absl::SimpleAtoi(fields[2], &file.checksum)) {
      file.name = std::string(fields[0]);
      files.push_back(std::move(file));
    } else if (fields.size() == 1) {
      // The last number before the files is theirs.
      has_count = absl::SimpleAtoi(fields[0], &count);
    }
  }
  if (has_count && !files.empty() && count == files.size()) return files;
  return absl::DataLossError(
      absl::StrCat("backup ", path, ": the list of its files can't be read"));
}

absl::Status CompareWithSum(const std::string& folder, const SummedFile& file,
                            const BackupPace& pace) {
  const std::string path = absl::StrCat(folder, "/", file.name);
  errno = 0;
  std::ifstream bytes(path, std::ios::binary);
  const auto unreadable = [&path] {
    return absl::DataLossError(absl::StrCat(
        "backup ", path,
        ": can't be read: ", std::error_code(errno, std::generic_category()).message()));
  };
  if (!bytes) return unreadable();
  uint32_t sum = 0;
  std::string piece(kReadBytes, '\0');
  while (bytes) {
    if (!pace(piece.size())) return absl::CancelledError("backups are compared no more");
    bytes.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    sum = ExtendCrc32c(sum, {piece.data(), static_cast<size_t>(bytes.gcount())});
  }
  if (bytes.bad()) return unreadable();
  if (sum == file.checksum) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat("backup ", path, ": its checksum is ", sum,
                                          " and should be ", file.checksum,
                                          ": the disk of --backup-dir has lost some of it"));
}

}  // namespace corbslam::map_store
