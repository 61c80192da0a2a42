#include "services/security/audit_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

absl::StatusOr<std::unique_ptr<AuditFile>> AuditFile::Open(const std::string& path,
                                                           uint64_t max_bytes) {
  std::unique_ptr<AuditFile> file(new AuditFile(path, max_bytes));
  const absl::Status opened = file->Reopen();
  if (opened.ok()) return file;
  return absl::InvalidArgumentError(absl::StrCat("--audit-log: ", opened.message()));
}

AuditFile::~AuditFile() { Close(); }

void AuditFile::Close() {
  if (file_ >= 0) close(file_);
  file_ = -1;
}

absl::Status AuditFile::Fails(absl::string_view what) const {
  return absl::ResourceExhaustedError(
      absl::StrCat("can't ", what, " ", path_, ": ", std::strerror(errno)));
}

absl::Status AuditFile::Reopen() {
  Close();
  file_ =
      open(path_.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, S_IRUSR | S_IWUSR | S_IRGRP);
  if (file_ < 0) return Fails("open");
  struct stat state;
  if (fstat(file_, &state) != 0) return Fails("look at");
  is_plain_ = S_ISREG(state.st_mode);
  bytes_ = is_plain_ ? static_cast<uint64_t>(state.st_size) : 0;
  return absl::OkStatus();
}

bool AuditFile::IsStillThere() const {
  struct stat ours;
  struct stat there;
  return file_ >= 0 && fstat(file_, &ours) == 0 && stat(path_.c_str(), &there) == 0 &&
         ours.st_ino == there.st_ino && ours.st_dev == there.st_dev;
}

// What a link leads to is set aside, and the link stays.
absl::Status AuditFile::SetAside() {
  std::error_code error;
  const std::filesystem::path full = std::filesystem::canonical(path_, error);
  if (!error) std::filesystem::rename(full, full.string() + ".1", error);
  if (!error) return absl::OkStatus();
  errno = error.value();
  return Fails("rename");
}

absl::Status AuditFile::Append(absl::string_view line) {
  if (!IsStillThere()) RETURN_IF_ERROR(Reopen());
  const std::string text = absl::StrCat(line, "\n");
  // Devices and pipes have no length, and stay what they are.
  if (is_plain_ && bytes_ > 0 && bytes_ + text.size() > max_bytes_) {
    RETURN_IF_ERROR(SetAside());
    RETURN_IF_ERROR(Reopen());
  }
  const ssize_t written = write(file_, text.data(), text.size());
  if (written == static_cast<ssize_t>(text.size())) {
    bytes_ += text.size();
    return absl::OkStatus();
  }
  if (written >= 0) errno = ENOSPC;
  const absl::Status status = Fails("write");
  // A part of a line would spoil the next one, too.
  if (written > 0 && ftruncate(file_, static_cast<off_t>(bytes_)) != 0) Close();
  return status;
}

}  // namespace corbslam::services
