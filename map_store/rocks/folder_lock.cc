#include "map_store/rocks/folder_lock.h"

#include <rocksdb/env.h>

#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "slam/util/lock_holder.h"

namespace corbslam::map_store {

absl::StatusOr<std::unique_ptr<FolderLock>> FolderLock::Take(const std::string& directory) {
  std::error_code error;
  if (!std::filesystem::is_directory(directory, error)) {
    return absl::FailedPreconditionError(
        absl::StrCat("journal ", directory, ": there is no such folder"));
  }
  const std::string path = absl::StrCat(directory, "/LOCK");
  if (!std::filesystem::exists(path, error)) {
    return std::unique_ptr<FolderLock>(new FolderLock(nullptr));
  }
  rocksdb::FileLock* lock = nullptr;
  const rocksdb::Status locked = rocksdb::Env::Default()->LockFile(path, &lock);
  if (locked.ok()) return std::unique_ptr<FolderLock>(new FolderLock(lock));
  return absl::FailedPreconditionError(
      absl::StrCat("journal ", directory, ": the folder is in use: ", DescribeLockHolder(path),
                   "; stop it first (", locked.ToString(), ")"));
}

FolderLock::~FolderLock() {
  if (lock_ != nullptr) rocksdb::Env::Default()->UnlockFile(lock_);
}

}  // namespace corbslam::map_store
