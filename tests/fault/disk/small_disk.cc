#include "tests/fault/disk/small_disk.h"

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"

namespace corbslam::tests {
namespace {

absl::Status Failed(const std::string& folder, absl::string_view what, int error = errno) {
  const std::string message = absl::StrCat("disk ", folder, ": ", what, ": ", std::strerror(error));
  if (error == EPERM || error == EACCES) return absl::PermissionDeniedError(message);
  return absl::UnavailableError(message);
}

}  // namespace

absl::StatusOr<std::unique_ptr<SmallDisk>> SmallDisk::Mount(const std::string& folder,
                                                            uint64_t bytes) {
  if (unshare(CLONE_NEWNS) != 0) return Failed(folder, "no mounts of our own");
  if (mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) {
    return Failed(folder, "can't keep mounts to ourselves");
  }
  if (mount("tmpfs", folder.c_str(), "tmpfs", 0, absl::StrCat("size=", bytes).c_str()) != 0) {
    return Failed(folder, "can't be mounted");
  }
  return std::unique_ptr<SmallDisk>(new SmallDisk(folder));
}

SmallDisk::~SmallDisk() { umount2(folder_.c_str(), MNT_DETACH); }

absl::Status SmallDisk::Fill(uint64_t left_bytes) {
  std::error_code error;
  const uint64_t free = std::filesystem::space(folder_, error).available;
  if (error) return Failed(folder_, "no size", error.value());
  if (free <= left_bytes) return absl::OkStatus();
  const int file = open(Filler().c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
  if (file < 0) return Failed(folder_, "no filler");
  const int failed = posix_fallocate(file, 0, static_cast<off_t>(free - left_bytes));
  close(file);
  return failed == 0 ? absl::OkStatus() : Failed(folder_, "can't be filled", failed);
}

absl::Status SmallDisk::Empty() {
  return unlink(Filler().c_str()) == 0 ? absl::OkStatus() : Failed(folder_, "can't be emptied");
}

absl::Status SmallDisk::SwitchReadOnly(bool on) {
  const std::string path = folder_ + ".read_only";
  if (!on) return unlink(path.c_str()) == 0 ? absl::OkStatus() : Failed(folder_, "no switch");
  const int file = open(path.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
  if (file < 0) return Failed(folder_, "no switch");
  close(file);
  return absl::OkStatus();
}

absl::Status SmallDisk::MakeReadOnly() {
  const unsigned long how = MS_REMOUNT | MS_RDONLY;
  if (mount("tmpfs", folder_.c_str(), "tmpfs", how, nullptr) == 0) return absl::OkStatus();
  return Failed(folder_, "can't be made read-only");
}

}  // namespace corbslam::tests
