// Appends lines to a file that grows no further than it may.
#ifndef CORBSLAM_SERVICES_SECURITY_AUDIT_FILE_H_
#define CORBSLAM_SERVICES_SECURITY_AUDIT_FILE_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam::services {

// A file of lines. When it is full it becomes FILE.1, in place of the FILE.1 before, so that both
// together never have more than twice the bound. A file that others have moved away or removed is
// made anew, so that logrotate needs no signal. Not thread-safe.
class AuditFile {
 public:
  // Opens the file, and makes it (readable by its owner and group) if it is not there.
  // INVALID_ARGUMENT names flag, file and reason.
  static absl::StatusOr<std::unique_ptr<AuditFile>> Open(const std::string& path,
                                                         uint64_t max_bytes);
  ~AuditFile();
  AuditFile(const AuditFile&) = delete;
  AuditFile& operator=(const AuditFile&) = delete;

  // Appends the line and its end, both or neither. RESOURCE_EXHAUSTED with the reason if the disk
  // is full, or the file can't be written for another cause; the next line may do better.
  absl::Status Append(absl::string_view line);

 private:
  AuditFile(std::string path, uint64_t max_bytes) : path_(std::move(path)), max_bytes_(max_bytes) {}

  absl::Status Reopen();
  absl::Status SetAside();
  void Close();
  // Returns true if the path leads to the file that is open.
  bool IsStillThere() const;
  absl::Status Fails(absl::string_view what) const;

  const std::string path_;
  const uint64_t max_bytes_;
  int file_ = -1;
  uint64_t bytes_ = 0;
  bool is_plain_ = false;  // The open file is one, and no device or pipe.
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_AUDIT_FILE_H_
