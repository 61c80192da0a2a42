#include "slam/util/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "absl/strings/str_cat.h"

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

}  // namespace

absl::StatusOr<WholeFile> WholeFile::Create(const std::string& path, Old old) {
  std::error_code error;
  if (old == Old::kKept && std::filesystem::exists(path, error)) {
    return absl::AlreadyExistsError(absl::StrCat("there is a file ", path, " already"));
  }
  WholeFile file(path, -1);
  file.fd_ =
      open(file.PartPath().c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, S_IRUSR | S_IWUSR);
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
  if (rename(PartPath().c_str(), path_.c_str()) != 0) return Failed("rename");
  close(std::exchange(fd_, -1));
  return SyncFolderOf(path_) ? absl::OkStatus() : Failed("rename");
}

}  // namespace corbslam
