#include "services/programs/kept_settings.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "services/security/pem_files.h"
#include "slam/util/atomic_file.h"
#include "slam/util/checksum.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Before the list stands the checksum of its bytes, as a field of the message that older robots
// pass over: 15, of four bytes.
constexpr char kChecksumField = (15 << 3) | 5;
constexpr size_t kHeadBytes = 5;

std::string HeadOf(absl::string_view list) {
  uint32_t crc = ExtendCrc32c(0, list);
  std::string head(1, kChecksumField);
  for (int i = 0; i < 4; ++i, crc >>= 8) head.push_back(static_cast<char>(crc & 0xff));
  return head;
}

absl::Status Damaged(const std::string& path, absl::string_view how) {
  return absl::DataLossError(absl::StrCat(
      "--settings-kept ", path, " ", how,
      ": settings that this robot took before are not known any more. Take the file back from "
      "where it is good, or name another one"));
}

}  // namespace

absl::StatusOr<v1::RobotSettingsList> ReadKeptSettings(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error) && !error) return v1::RobotSettingsList();
  const absl::StatusOr<std::string> read = ReadListFile("--settings-kept", path);
  if (!read.ok()) return absl::UnavailableError(read.status().message());
  const std::string& bytes = *read;
  if (bytes.empty()) return Damaged(path, "is empty");
  absl::string_view list_bytes = bytes;
  if (bytes[0] == kChecksumField) {
    list_bytes = list_bytes.substr(std::min(kHeadBytes, list_bytes.size()));
    if (bytes.substr(0, kHeadBytes) != HeadOf(list_bytes)) {
      return Damaged(path, "is damaged or cut short");
    }
  }
  v1::RobotSettingsList list;
  const bool is_read = list.ParseFromArray(list_bytes.data(), static_cast<int>(list_bytes.size()));
  if (is_read && !list.settings().empty()) return list;
  return Damaged(path, "can't be read as settings that a robot kept");
}

absl::Status WriteKeptSettings(const v1::RobotSettingsList& list, const std::string& path) {
  if (absl::IsDataLoss(ReadKeptSettings(path).status())) {
    std::error_code error;
    std::filesystem::rename(path, path + ".damaged", error);
    if (error) {
      return absl::UnavailableError(
          absl::StrCat("can't put --settings-kept ", path, " aside: ", error.message()));
    }
  }
  const std::string bytes = list.SerializeAsString();
  const auto write = [&]() -> absl::Status {
    ASSIGN_OR_RETURN(AtomicFile file, AtomicFile::Create(path, AtomicFile::Old::kReplaced));
    RETURN_IF_ERROR(file.Append(HeadOf(bytes)));
    RETURN_IF_ERROR(file.Append(bytes));
    return file.Finish();
  };
  const absl::Status written = write();
  if (written.ok()) return written;
  return absl::Status(written.code(), absl::StrCat("--settings-kept ", path,
                                                   ": what was taken would not outlive this "
                                                   "process: ",
                                                   written.message()));
}

}  // namespace corbslam::services
