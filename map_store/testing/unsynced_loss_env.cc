#include "map_store/testing/unsynced_loss_env.h"

#include <algorithm>
#include <filesystem>
#include <utility>

namespace corbslam::testing {
namespace {

namespace fs = std::filesystem;

std::string Normal(const std::string& path) { return fs::path(path).lexically_normal().string(); }

class WatchedFile : public rocksdb::WritableFileWrapper {
 public:
  WatchedFile(std::unique_ptr<rocksdb::WritableFile> file, std::string name, UnsyncedLossEnv* env)
      : rocksdb::WritableFileWrapper(file.get()),
        file_(std::move(file)),
        name_(std::move(name)),
        env_(env) {}

  rocksdb::Status Append(const rocksdb::Slice& data) override {
    if (env_->IsFull()) return rocksdb::Status::NoSpace("no room on the test's disk");
    written_ += data.size();
    return file_->Append(data);
  }
  rocksdb::Status Append(const rocksdb::Slice& data,
                         const rocksdb::DataVerificationInfo&) override {
    return Append(data);
  }
  rocksdb::Status Sync() override { return Note(file_->Sync()); }
  rocksdb::Status Fsync() override { return Note(file_->Fsync()); }

 private:
  rocksdb::Status Note(const rocksdb::Status& status) {
    if (status.ok()) env_->NoteSynced(name_, written_);
    return status;
  }

  const std::unique_ptr<rocksdb::WritableFile> file_;
  const std::string name_;
  UnsyncedLossEnv* const env_;
  uint64_t written_ = 0;
};

}  // namespace

void UnsyncedLossEnv::CopyAfterPowerCut(const std::string& from, const std::string& to) {
  fs::remove_all(to);
  fs::create_directories(to);
  absl::MutexLock lock(&mutex_);
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(from)) {
    const fs::path copy = fs::path(to) / fs::relative(entry.path(), from);
    if (entry.is_directory()) fs::create_directories(copy);
    if (!entry.is_regular_file()) continue;
    fs::copy_file(entry.path(), copy);
    const auto it = synced_.find(Normal(entry.path().string()));
    if (it != synced_.end()) fs::resize_file(copy, std::min(it->second, fs::file_size(copy)));
  }
}

void UnsyncedLossEnv::SetFull(bool full) {
  absl::MutexLock lock(&mutex_);
  full_ = full;
}

bool UnsyncedLossEnv::IsFull() const {
  absl::MutexLock lock(&mutex_);
  return full_;
}

void UnsyncedLossEnv::NoteSynced(const std::string& file, uint64_t size) {
  absl::MutexLock lock(&mutex_);
  synced_[file] = size;
}

rocksdb::Status UnsyncedLossEnv::NewWritableFile(const std::string& name,
                                                 std::unique_ptr<rocksdb::WritableFile>* file,
                                                 const rocksdb::EnvOptions& options) {
  if (IsFull()) return rocksdb::Status::NoSpace("no room on the test's disk");
  std::unique_ptr<rocksdb::WritableFile> opened;
  const rocksdb::Status status = target()->NewWritableFile(name, &opened, options);
  if (!status.ok()) return status;
  NoteSynced(Normal(name), 0);
  *file = std::make_unique<WatchedFile>(std::move(opened), Normal(name), this);
  return status;
}

rocksdb::Status UnsyncedLossEnv::RenameFile(const std::string& from, const std::string& to) {
  absl::MutexLock lock(&mutex_);
  const rocksdb::Status status = target()->RenameFile(from, to);
  synced_.erase(Normal(from));
  synced_.erase(Normal(to));  // All of it counts as synced.
  return status;
}

rocksdb::Status UnsyncedLossEnv::DeleteFile(const std::string& name) {
  absl::MutexLock lock(&mutex_);
  synced_.erase(Normal(name));
  return target()->DeleteFile(name);
}

}  // namespace corbslam::testing
