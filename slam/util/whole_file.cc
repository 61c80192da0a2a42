#include "slam/util/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

// Makes the folder's list of names durable, which must survive, too.
bool SyncFolderOf(const std::string& path) {
  std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (folder.empty()) folder = ".";
  const int fd = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool synced = fsync(fd) == 0;
  close(fd);
  return synced;
}

// Writes to what is no plain file: another one in its place would not be it.
absl::Status WriteThrough(const std::string& path, absl::string_view bytes) {
  errno = 0;
  std::ofstream file(path, std::ios::binary);
  file << bytes;
  file.close();
  const int failure = errno;
  if (file) return absl::OkStatus();
  const std::string message = absl::StrCat("can't write ", path, ": ", std::strerror(failure));
  return failure == ENOSPC ? absl::ResourceExhaustedError(message)
                           : absl::UnavailableError(message);
}

}  // namespace

absl::StatusOr<WholeFile> WholeFile::Create(const std::string& path, Old old, Readers readers) {
  std::error_code error;
  if (old == Old::kKept && std::filesystem::exists(path, error)) {
    return absl::AlreadyExistsError(absl::StrCat("there is a file ", path, " already"));
  }
  WholeFile file(path, -1);
  const mode_t others = readers == Readers::kOwner ? 0 : S_IRGRP | S_IWGRP | S_IROTH | S_IWOTH;
  file.fd_ = open(file.PartPath().c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC,
                  S_IRUSR | S_IWUSR | others);
  if (file.fd_ < 0) return file.Failed("make");
  return file;
}

WholeFile::WholeFile(WholeFile&& other) noexcept
    : path_(std::move(other.path_)), fd_(std::exchange(other.fd_, -1)) {}

WholeFile::~WholeFile() {
  if (fd_ < 0) return;
  close(fd_);
  unlink(PartPath().c_str());
}

absl::Status WholeFile::Failed(absl::string_view action) const {
  const int error = errno;
  const std::string message =
      absl::StrCat("can't ", action, " ", PartPath(), ": ", std::strerror(error));
  if (error == ENOSPC || error == EDQUOT) return absl::ResourceExhaustedError(message);
  return absl::UnavailableError(message);
}

absl::Status WholeFile::Append(absl::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(fd_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return Failed("write");
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  return absl::OkStatus();
}

absl::Status WholeFile::Finish() {
  if (fsync(fd_) != 0) return Failed("write");
  RETURN_IF_ERROR(FinishUnsynced());
  return SyncFolderOf(path_) ? absl::OkStatus() : Failed("rename");
}

absl::Status WholeFile::FinishUnsynced() {
  if (rename(PartPath().c_str(), path_.c_str()) != 0) return Failed("rename");
  if (close(std::exchange(fd_, -1)) != 0) return Failed("write");
  return absl::OkStatus();
}

absl::Status WriteWhole(const std::string& path, absl::string_view bytes) {
  std::error_code error;
  const std::filesystem::file_status there = std::filesystem::status(path, error);
  if (std::filesystem::is_directory(there)) {
    return absl::InvalidArgumentError(
        absl::StrCat("can't write ", path, ": it is a folder; name a file in it"));
  }
  // What stands under /dev/stdout may be a plain file that somebody has open.
  const bool is_device = absl::StartsWith(path, "/dev/") || absl::StartsWith(path, "/proc/");
  if (is_device || (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there))) {
    return WriteThrough(path, bytes);
  }
  std::string target = path;
  if (std::filesystem::is_symlink(std::filesystem::symlink_status(path, error))) {
    const std::filesystem::path linked = std::filesystem::canonical(path, error);
    if (!error) target = linked.string();
  }
  ASSIGN_OR_RETURN(WholeFile file, WholeFile::Create(target, WholeFile::Old::kReplaced,
                                                     WholeFile::Readers::kOthersToo));
  if (std::filesystem::exists(there)) {
    std::filesystem::permissions(target + ".part", there.permissions(), error);
  }
  RETURN_IF_ERROR(file.Append(bytes));
  return file.FinishUnsynced();
}

}  // namespace corbslam
