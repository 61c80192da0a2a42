// A file system for tests of power cuts: it knows what of each file has been synced.
#ifndef CORBSLAM_MAP_STORE_TESTING_UNSYNCED_LOSS_ENV_H_
#define CORBSLAM_MAP_STORE_TESTING_UNSYNCED_LOSS_ENV_H_

#include <rocksdb/env.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace corbslam::testing {

// Writes go through to the system's files; a rename counts as synced. Thread-safe.
class UnsyncedLossEnv : public rocksdb::EnvWrapper {
 public:
  UnsyncedLossEnv() : rocksdb::EnvWrapper(rocksdb::Env::Default()) {}

  // Copies a folder as it would be found if the power went now: every file ends where it was last
  // synced, and files never synced are empty.
  void CopyAfterPowerCut(const std::string& from, const std::string& to);

  // Says whether writes find no room from now on.
  void SetFull(bool full);
  bool IsFull() const;
  void NoteSynced(const std::string& file, uint64_t size);

  rocksdb::Status NewWritableFile(const std::string& name,
                                  std::unique_ptr<rocksdb::WritableFile>* file,
                                  const rocksdb::EnvOptions& options) override;
  rocksdb::Status RenameFile(const std::string& from, const std::string& to) override;
  rocksdb::Status DeleteFile(const std::string& name) override;

 private:
  mutable absl::Mutex mutex_;
  // By path: how many bytes are safe of each file that was written through this environment.
  std::map<std::string, uint64_t> synced_ ABSL_GUARDED_BY(mutex_);
  bool full_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_UNSYNCED_LOSS_ENV_H_
