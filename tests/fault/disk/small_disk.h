// Makes a disk that a test can fill.
#ifndef CORBSLAM_TESTS_FAULT_DISK_SMALL_DISK_H_
#define CORBSLAM_TESTS_FAULT_DISK_SMALL_DISK_H_

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace corbslam::tests {

// The disk is in memory (tmpfs). Only this thread, and the processes that it starts, see it; it
// goes with them.
class SmallDisk {
 public:
  // Mounts the disk on the folder, which must be there. PERMISSION_DENIED where this process may
  // not (it needs to be root); UNAVAILABLE with the system's word otherwise.
  static absl::StatusOr<std::unique_ptr<SmallDisk>> Mount(const std::string& folder,
                                                          uint64_t bytes);
  ~SmallDisk();
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  const std::string& folder() const { return folder_; }
  // Fills the disk but for so much.
  absl::Status Fill(uint64_t left_bytes);
  absl::Status Empty();
  // Makes the disk read-only. No process may have a file of it open for writing.
  absl::Status MakeReadOnly();
  // Does the same for programs that were started with read_only_switch.cc, also while they write.
  absl::Status SwitchReadOnly(bool on);

 private:
  explicit SmallDisk(std::string folder) : folder_(std::move(folder)) {}
  std::string Filler() const { return folder_ + "/filler"; }

  const std::string folder_;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FAULT_DISK_SMALL_DISK_H_
