// Writes a file that is there under its name only once it is whole.
#ifndef CORBSLAM_SLAM_UTIL_WHOLE_FILE_H_
#define CORBSLAM_SLAM_UTIL_WHOLE_FILE_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam {

// One file that is being written. Not thread-safe. Errors name the file: RESOURCE_EXHAUSTED for a
// full disk, else UNAVAILABLE.
class WholeFile {
 public:
  // What becomes of a file that is at the path already.
  enum class Old { kKept, kReplaced };

  // Who may read it: others, too, are asked by the process's umask.
  enum class Readers { kOwner, kOthersToo };

  // Begins a file at `path` with ".part" at its end. ALREADY_EXISTS if there is one at `path` that
  // is to be kept; one that is to be replaced stays until Finish.
  static absl::StatusOr<WholeFile> Create(const std::string& path, Old old = Old::kKept,
                                          Readers readers = Readers::kOwner);
  WholeFile(WholeFile&& other) noexcept;
  WholeFile& operator=(WholeFile&&) = delete;
  // Removes the file if it was not finished.
  ~WholeFile();

  absl::Status Append(absl::string_view bytes);
  // Gives the file its name, durably. The caller does so once, as the last call.
  absl::Status Finish();
  // The same for what can be made again: a power loss may take it.
  absl::Status FinishUnsynced();

 private:
  WholeFile(std::string path, int fd) : path_(std::move(path)), fd_(fd) {}
  std::string PartPath() const { return path_ + ".part"; }
  absl::Status Failed(absl::string_view action) const;

  std::string path_;
  int fd_;
};

// Makes `bytes` the contents of the file at `path`: of a plain file all of them, or it stays what
// it was. Links are followed; devices and pipes are written to as they are. Not synced. Errors name
// the file and why: INVALID_ARGUMENT for a folder, else as WholeFile's.
absl::Status WriteWhole(const std::string& path, absl::string_view bytes);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_WHOLE_FILE_H_
