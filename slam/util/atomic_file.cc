#include "slam/util/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

namespace fs = std::filesystem;

// Makes the folder's list of names durable, which must survive, too.
bool SyncFolderOf(const std::string& path) {
  fs::path folder = fs::path(path).parent_path();
  if (folder.empty()) folder = ".";
  const int fd = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool synced = fsync(fd) == 0;
  close(fd);
  return synced;
}

absl::Status Error(absl::string_view action, absl::string_view path) {
  const int error = errno;
  const std::string message = absl::StrCat("can't ", action, " ", path, ": ", std::strerror(error));
  if (error == ENOSPC || error == EDQUOT) return absl::ResourceExhaustedError(message);
  return absl::UnavailableError(message);
}

// What stands under such a name is the kernel's, even where it looks like a plain file.
bool IsOfTheKernel(absl::string_view path) {
  for (const char* folder : {"/dev/", "/proc/", "/sys/"}) {
    if (absl::StartsWith(path, folder) && !absl::StartsWith(path, "/dev/shm/")) return true;
  }
  return false;
}

// Returns where links lead; what is there need not exist.
absl::StatusOr<std::string> FollowLinks(const std::string& path) {
  constexpr int kMostLinks = 40;
  fs::path target = path;
  for (int i = 0; i < kMostLinks; ++i) {
    std::error_code error;
    if (IsOfTheKernel(target.native())) return target.string();
    if (!fs::is_symlink(fs::symlink_status(target, error))) return target.string();
    const fs::path next = fs::read_symlink(target, error);
    if (error) return absl::UnavailableError(absl::StrCat("can't read the link ", target.string()));
    target = next.is_absolute() ? next : target.parent_path() / next;
  }
  return absl::UnavailableError(
      absl::StrCat("can't write ", path, ": its links lead to each other"));
}

// Returns the number of a file that this process has open, for the names that stand for such.
std::optional<int> OpenNumber(absl::string_view path) {
  if (path == "/dev/stdout") return STDOUT_FILENO;
  if (path == "/dev/stderr") return STDERR_FILENO;
  int number = 0;
  for (const char* folder : {"/dev/fd/", "/proc/self/fd/"}) {
    absl::string_view rest = path;
    if (absl::ConsumePrefix(&rest, folder) && absl::SimpleAtoi(rest, &number)) return number;
  }
  return std::nullopt;
}

// Opens what is no plain file, to be written to as it is. What this process has open already is
// written on where it stands, so that nothing that others wrote there is lost.
absl::StatusOr<int> OpenInPlace(const std::string& path) {
  const std::optional<int> number = OpenNumber(path);
  const int fd = number.has_value() ? fcntl(*number, F_DUPFD_CLOEXEC, 0)
                                    : open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
  if (fd < 0) return Error("write", path);
  struct stat state;
  if (fstat(fd, &state) != 0 || !S_ISBLK(state.st_mode)) return fd;
  close(fd);
  return absl::InvalidArgumentError(
      absl::StrCat("can't write ", path, ": it is a disk, whose contents that would destroy"));
}

absl::Status IsInTheWay(const std::string& part, absl::string_view why) {
  return absl::FailedPreconditionError(absl::StrCat("can't make ", part, ": ", why));
}

// Removes what a process that broke off left under the name.
absl::Status RemoveLeftOver(const std::string& part) {
  struct stat there;
  if (lstat(part.c_str(), &there) != 0) return absl::OkStatus();
  if (!S_ISREG(there.st_mode)) return IsInTheWay(part, "something else has that name");
  const int fd = open(part.c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (fd < 0) return errno == ENOENT ? absl::OkStatus() : Error("make", part);
  const bool is_held = flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  struct stat ours;
  const bool is_it = fstat(fd, &ours) == 0 && lstat(part.c_str(), &there) == 0 &&
                     ours.st_ino == there.st_ino && ours.st_dev == there.st_dev;
  if (!is_held && is_it) unlink(part.c_str());
  close(fd);
  return is_held ? IsInTheWay(part, "another process is writing it") : absl::OkStatus();
}

// Makes the file and holds it, so that no other process takes it for one that was left over.
absl::StatusOr<int> OpenPart(const std::string& part, mode_t mode) {
  constexpr int kTries = 10;
  for (int i = 0; i < kTries; ++i) {
    const int fd = open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (fd < 0 && errno != EEXIST) return Error("make", part);
    if (fd < 0) {
      RETURN_IF_ERROR(RemoveLeftOver(part));
      continue;
    }
    struct stat ours;
    struct stat there;
    // A file system that has no such locks does without.
    const bool is_held = flock(fd, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
    if (is_held && fstat(fd, &ours) == 0 && lstat(part.c_str(), &there) == 0 &&
        ours.st_ino == there.st_ino) {
      return fd;
    }
    close(fd);
  }
  return IsInTheWay(part, "other processes are writing it");
}

absl::Status CheckKind(const std::string& path, fs::file_type type) {
  const char* why = nullptr;
  if (type == fs::file_type::directory) why = "it is a folder; name a file in it";
  if (type == fs::file_type::socket) why = "it is a socket";
  if (type == fs::file_type::block) why = "it is a disk, whose contents that would destroy";
  if (why == nullptr) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("can't write ", path, ": ", why));
}

bool IsPlainOrNothing(const std::string& target, fs::file_type type) {
  return !IsOfTheKernel(target) &&
         (type == fs::file_type::regular || type == fs::file_type::not_found);
}

}  // namespace

absl::StatusOr<AtomicFile> AtomicFile::Create(const std::string& path, Old old, Readers readers) {
  std::error_code error;
  if (old == Old::kStays && fs::exists(fs::symlink_status(path, error))) {
    return absl::AlreadyExistsError(absl::StrCat("there is a file ", path, " already"));
  }
  ASSIGN_OR_RETURN(const std::string target, FollowLinks(path));
  const fs::file_status there = fs::status(target, error);
  RETURN_IF_ERROR(CheckKind(path, there.type()));
  if (!IsPlainOrNothing(target, there.type())) {
    ASSIGN_OR_RETURN(const int fd, OpenInPlace(target));
    return AtomicFile(target, fd, /*in_place=*/true);
  }
  const mode_t others = readers == Readers::kOthersToo ? S_IRGRP | S_IWGRP | S_IROTH | S_IWOTH : 0;
  ASSIGN_OR_RETURN(const int fd, OpenPart(target + ".part", S_IRUSR | S_IWUSR | others));
  if (fs::exists(there) && readers != Readers::kOwnerAlways) {
    // Best as far as the file system knows permissions.
    [[maybe_unused]] const int kept = fchmod(fd, static_cast<mode_t>(there.permissions()) & 0777);
  }
  return AtomicFile(target, fd, /*in_place=*/false);
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      fd_(std::exchange(other.fd_, -1)),
      in_place_(other.in_place_) {}

AtomicFile::~AtomicFile() {
  if (fd_ < 0) return;
  if (!in_place_) unlink(WrittenPath().c_str());
  close(fd_);
}

absl::Status AtomicFile::Failed(absl::string_view action) const {
  return Error(action, WrittenPath());
}

absl::Status AtomicFile::Append(absl::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(fd_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return Failed("write");
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  return absl::OkStatus();
}

absl::Status AtomicFile::Finish() {
  if (in_place_) return FinishUnsynced();
  if (fsync(fd_) != 0) return Failed("write");
  RETURN_IF_ERROR(FinishUnsynced());
  return SyncFolderOf(path_) ? absl::OkStatus() : Failed("rename");
}

absl::Status AtomicFile::FinishUnsynced() {
  if (!in_place_ && rename(WrittenPath().c_str(), path_.c_str()) != 0) return Failed("rename");
  if (close(std::exchange(fd_, -1)) != 0) return Failed("write");
  return absl::OkStatus();
}

absl::Status WriteAtomically(const std::string& path, absl::string_view bytes) {
  ASSIGN_OR_RETURN(AtomicFile file, AtomicFile::Create(path, AtomicFile::Old::kReplaced,
                                                       AtomicFile::Readers::kOthersToo));
  RETURN_IF_ERROR(file.Append(bytes));
  return file.FinishUnsynced();
}

bool IsForPlainFile(const std::string& path) {
  const absl::StatusOr<std::string> target = FollowLinks(path);
  std::error_code error;
  return target.ok() && IsPlainOrNothing(*target, fs::status(*target, error).type());
}

absl::Status CheckForPlainFile(const std::string& path, absl::string_view what) {
  if (IsForPlainFile(path)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("can't write ", path, ": it is no plain file, and ", what));
}

}  // namespace corbslam
