// Writes a file that is there under its name only once it is complete.
#ifndef CORBSLAM_SLAM_UTIL_ATOMIC_FILE_H_
#define CORBSLAM_SLAM_UTIL_ATOMIC_FILE_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam {

// One file that is being written. Not thread-safe. Only a plain file is ever replaced: links are
// followed and stay, devices and pipes are written to as they are. Errors name the file:
// INVALID_ARGUMENT for a folder, a socket or a disk, RESOURCE_EXHAUSTED for a full disk,
// FAILED_PRECONDITION where another process writes it, else UNAVAILABLE.
class AtomicFile {
 public:
  // What becomes of a file that is at the path already.
  enum class Old { kStays, kReplaced };

  // Who may read it: others, too, are asked by the process's umask. A file that takes another one's
  // place has that one's permissions, but for kOwnerAlways.
  enum class Readers { kOwner, kOwnerAlways, kOthersToo };

  // Begins a file at `path` with ".part" at its end. ALREADY_EXISTS if there is anything at `path`
  // and it is to be kept; one that is to be replaced stays until Finish.
  static absl::StatusOr<AtomicFile> Create(const std::string& path, Old old = Old::kStays,
                                           Readers readers = Readers::kOwner);
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;
  // Removes the file if it was not finished.
  ~AtomicFile();

  absl::Status Append(absl::string_view bytes);
  // Gives the file its name, durably. The caller does so once, as the last call.
  absl::Status Finish();
  // Does the same for a file that can be made again: a power loss may take it.
  absl::Status FinishUnsynced();

 private:
  AtomicFile(std::string path, int fd, bool in_place)
      : path_(std::move(path)), fd_(fd), in_place_(in_place) {}
  std::string WrittenPath() const { return in_place_ ? path_ : path_ + ".part"; }
  absl::Status Failed(absl::string_view action) const;

  std::string path_;  // Where links lead.
  int fd_;
  bool in_place_;  // A device or a pipe: there is no ".part" of it.
};

// Makes `bytes` the contents of the file at `path`, as AtomicFile does: of a plain file all of
// them, or it stays what it was. Not synced.
absl::Status WriteAtomically(const std::string& path, absl::string_view bytes);

// Returns true if what is written to `path` makes a plain file, so that others may lie beside it;
// false for devices and pipes, also where links lead to them.
bool IsForPlainFile(const std::string& path);

// Returns an error for a path of which IsForPlainFile is false: `what` are several files.
absl::Status CheckForPlainFile(const std::string& path, absl::string_view what);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_ATOMIC_FILE_H_
