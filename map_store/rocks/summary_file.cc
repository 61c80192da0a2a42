#include "map_store/rocks/summary_file.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "map_store/archive/archive.h"
#include "slam/util/atomic_file.h"
#include "slam/util/checksum.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

constexpr uint64_t kSummaryMagic = 0x31'59'52'41'4d'4d'55'53;  // "SUMMARY1" in the file.
// No summary is longer; more would be somebody else's file.
constexpr uintmax_t kMaxSummaryBytes = 1 << 20;

std::string PathOfSummary(const std::string& folder) {
  return absl::StrCat(folder, "/", kSummaryFile);
}

absl::StatusOr<std::string> ReadWhole(const std::string& path) {
  std::error_code error;
  const uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return absl::NotFoundError(absl::StrCat(path, ": ", error.message()));
  if (size > kMaxSummaryBytes) return absl::DataLossError(absl::StrCat(path, " is too long"));
  std::ifstream file(path, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (!file.bad() && bytes.size() == size) return bytes;
  return absl::DataLossError(absl::StrCat(path, " can't be read"));
}

// RocksDB keeps the name of its newest list of files in this file.
absl::StatusOr<std::string> ReadCurrent(const std::string& folder) {
  return ReadWhole(absl::StrCat(folder, "/CURRENT"));
}

}  // namespace

absl::Status WriteSummaryFile(const std::string& folder, absl::string_view summary) {
  ASSIGN_OR_RETURN(const std::string current, ReadCurrent(folder));
  ArchiveWriter writer;
  writer(kSummaryMagic, current, std::string(summary));
  std::string bytes = writer.Take();
  ArchiveWriter sum;
  sum(ExtendCrc32c(0, bytes));
  ASSIGN_OR_RETURN(AtomicFile file,
                   AtomicFile::Create(PathOfSummary(folder), AtomicFile::Old::kReplaced));
  RETURN_IF_ERROR(file.Append(bytes));
  RETURN_IF_ERROR(file.Append(sum.Take()));
  return file.Finish();
}

absl::StatusOr<std::string> ReadSummaryFile(const std::string& folder) {
  const std::string path = PathOfSummary(folder);
  ASSIGN_OR_RETURN(const std::string bytes, ReadWhole(path));
  const absl::Status damaged = absl::DataLossError(path + " is damaged");
  uint32_t sum = 0;
  if (bytes.size() < sizeof(sum)) return damaged;
  const std::string_view content = std::string_view(bytes).substr(0, bytes.size() - sizeof(sum));
  ArchiveReader sum_reader(std::string_view(bytes).substr(content.size()));
  sum_reader(sum);
  ArchiveReader reader(content);
  uint64_t magic = 0;
  std::string current;
  std::string summary;
  reader(magic, current, summary);
  const absl::string_view summed(content.data(), content.size());
  if (!reader.done() || magic != kSummaryMagic || sum != ExtendCrc32c(0, summed)) return damaged;
  const absl::StatusOr<std::string> now = ReadCurrent(folder);
  if (now.ok() && *now == current) return summary;
  return absl::DataLossError(absl::StrCat(
      path, " is older than what it is about: something has opened the mission since"));
}

void RemoveSummaryFile(const std::string& folder) {
  std::error_code error;
  std::filesystem::remove(PathOfSummary(folder), error);
}

}  // namespace corbslam::map_store
