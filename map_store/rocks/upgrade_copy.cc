#include "map_store/rocks/upgrade_copy.h"

#include <fcntl.h>
#include <unistd.h>

#include <filesystem>
#include <system_error>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "map_store/rocks/journal_folder.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;

constexpr char kCopyPrefix[] = "before-";
// Left free beside the copy: the journal itself has to go on.
constexpr uint64_t kLeftFree_bytes = uint64_t{64} << 20;

absl::Status CopyFailed(const fs::path& path, const std::error_code& error) {
  const std::string message = absl::StrCat(
      "the copy of the journal from before its upgrade: ", path.string(), ": ", error.message());
  if (error == std::errc::no_space_on_device) return absl::ResourceExhaustedError(message);
  return absl::UnavailableError(message);
}

// Whether the file is of no use to the program that takes the copy.
bool IsPassedOver(const std::string& name) {
  return name == "LOCK" || name == "LOG" || absl::StartsWith(name, "LOG.old");
}

struct CopiedFile {
  fs::path from;
  // Below the journal's folder.
  fs::path name;
  uint64_t bytes = 0;
  bool is_table() const { return from.extension() == ".sst"; }
};

// Lists the regular files of the journal, those of earlier copies left out.
absl::StatusOr<std::vector<CopiedFile>> ListFiles(const fs::path& directory) {
  std::vector<CopiedFile> files;
  std::error_code error;
  fs::recursive_directory_iterator it(directory, error);
  for (; !error && it != fs::recursive_directory_iterator(); it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (it->is_directory(error) && it.depth() == 0 && absl::StartsWith(name, kCopyPrefix)) {
      it.disable_recursion_pending();
    }
    if (!it->is_regular_file(error) || IsPassedOver(name)) continue;
    files.push_back({.from = it->path(),
                     .name = it->path().lexically_relative(directory),
                     .bytes = it->file_size(error)});
  }
  if (error) return CopyFailed(directory, error);
  return files;
}

absl::Status CheckRoomForCopy(const fs::path& directory, const std::vector<CopiedFile>& files) {
  uint64_t needed = kLeftFree_bytes;
  for (const CopiedFile& file : files) needed += file.is_table() ? 0 : file.bytes;
  std::error_code error;
  const fs::space_info space = fs::space(directory, error);
  if (error) return CopyFailed(directory, error);
  if (space.available >= needed) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("journal ", directory.string(),
                   ": it is of an older format, and a copy of it is kept before ",
                   "that is changed, for which ", needed >> 20, " MiB must be free: there are ",
                   space.available >> 20, "; make room. Nothing was changed"));
}

absl::Status CopyFile(const CopiedFile& file, const fs::path& to) {
  std::error_code error;
  fs::create_directories(to.parent_path(), error);
  if (error) return CopyFailed(to.parent_path(), error);
  if (file.is_table()) {
    fs::create_hard_link(file.from, to, error);
    if (!error) return absl::OkStatus();
  }
  fs::copy_file(file.from, to, error);
  return error ? CopyFailed(to, error) : absl::OkStatus();
}

// Makes all that was written to the disk of the folder outlive a power cut.
absl::Status SyncDisk(const fs::path& folder) {
  const int fd = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool done = fd >= 0 && syncfs(fd) == 0;
  const std::error_code error(errno, std::generic_category());
  if (fd >= 0) close(fd);
  return done ? absl::OkStatus() : CopyFailed(folder, error);
}

absl::Status CopyInto(const std::vector<CopiedFile>& files, const fs::path& making) {
  for (const CopiedFile& file : files) RETURN_IF_ERROR(CopyFile(file, making / file.name));
  return SyncDisk(making);
}

}  // namespace

std::string UpgradeCopyPath(const std::string& directory, uint32_t format) {
  return absl::StrCat(directory, "/", kCopyPrefix, format);
}

absl::Status KeepBeforeUpgrade(const std::string& directory, uint32_t format) {
  const fs::path kept = UpgradeCopyPath(directory, format);
  const fs::path making = kept.string() + ".making";
  std::error_code error;
  if (fs::exists(kept, error)) return absl::OkStatus();
  fs::remove_all(making, error);
  ASSIGN_OR_RETURN(const std::vector<CopiedFile> files, ListFiles(directory));
  RETURN_IF_ERROR(CheckRoomForCopy(directory, files));
  const absl::Status copied = CopyInto(files, making);
  if (!copied.ok()) {
    fs::remove_all(making, error);
    return copied;
  }
  fs::rename(making, kept, error);
  if (error) return CopyFailed(kept, error);
  return SyncFolder(directory);
}

}  // namespace corbslam::map_store
