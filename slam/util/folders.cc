#include "slam/util/folders.h"

#include <system_error>

#include "absl/strings/str_cat.h"

namespace corbslam {

namespace fs = std::filesystem;

absl::Status MakeFolder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (!error) return absl::OkStatus();
  return absl::UnavailableError(
      absl::StrCat("cannot make the folder ", path, ": ", error.message()));
}

absl::Status CheckNewFolder(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return absl::OkStatus();
  if (!fs::is_directory(path, error)) {
    return absl::FailedPreconditionError(absl::StrCat(path, " is no folder"));
  }
  const bool is_empty = fs::directory_iterator(path, error) == fs::directory_iterator();
  if (error) return absl::FailedPreconditionError(absl::StrCat(path, ": ", error.message()));
  if (is_empty) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat(path, " holds something already: remove it, or name a new folder"));
}

fs::path NearestThere(const std::string& path) {
  std::error_code error;
  fs::path there = fs::absolute(path, error);
  while (!fs::exists(there, error) && there.has_relative_path()) there = there.parent_path();
  return there;
}

}  // namespace corbslam
