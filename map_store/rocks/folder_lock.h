// Keeps a store out of a journal's folder without changing anything in it.
#ifndef CORBSLAM_MAP_STORE_ROCKS_FOLDER_LOCK_H_
#define CORBSLAM_MAP_STORE_ROCKS_FOLDER_LOCK_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace rocksdb {
class FileLock;
}  // namespace rocksdb

namespace corbslam::map_store {

// Holds the lock that a store holds as long as it runs.
class FolderLock {
 public:
  // FAILED_PRECONDITION: there is no journal, or a process, which is named, has it open. A folder
  // whose lock is lost can't be locked; the result then holds none.
  static absl::StatusOr<std::unique_ptr<FolderLock>> Take(const std::string& directory);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  explicit FolderLock(rocksdb::FileLock* lock) : lock_(lock) {}

  rocksdb::FileLock* const lock_;  // Null: none.
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_FOLDER_LOCK_H_
