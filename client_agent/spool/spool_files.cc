#include "client_agent/spool/spool_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/container/flat_hash_set.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "slam/util/lock_holder.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr char kLockName[] = "lock";

absl::Status FileError(absl::string_view what, absl::string_view path, int error) {
  const std::string message = absl::StrCat("can't ", what, " ", path, ": ", std::strerror(error));
  const bool full = error == ENOSPC || error == EDQUOT;
  return full ? absl::ResourceExhaustedError(message) : absl::UnavailableError(message);
}

// Returns DATA_LOSS where the file is gone or the disk can't read it: its bytes won't come back.
absl::Status ReadError(absl::string_view path, int error) {
  const absl::Status status = FileError("read", path, error);
  const bool lost = error == ENOENT || error == EIO;
  return lost ? absl::DataLossError(status.message()) : status;
}

// An open file, which is closed at the end.
class Descriptor final {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  int fd() const { return fd_; }

 private:
  int fd_;
};

absl::StatusOr<Descriptor> OpenFile(const std::string& path, int flags) {
  Descriptor file(open(path.c_str(), flags | O_CLOEXEC, 0600));
  if (file.fd() < 0) return FileError("open", path, errno);
  return file;
}

absl::Status SyncFolder(const std::string& path) {
  ASSIGN_OR_RETURN(const Descriptor folder, OpenFile(path, O_RDONLY | O_DIRECTORY));
  if (fsync(folder.fd()) == 0) return absl::OkStatus();
  return FileError("sync", path, errno);
}

class SpoolFolder final : public SpoolFiles {
 public:
  SpoolFolder(std::string path, Descriptor lock) : path_(std::move(path)), lock_(std::move(lock)) {}

  absl::StatusOr<std::vector<std::string>> List() override {
    std::vector<std::string> names;
    std::error_code error;
    for (std::filesystem::directory_iterator it(path_, error), end; !error && it != end;
         it.increment(error)) {
      const std::string name = it->path().filename().string();
      if (name != kLockName) names.push_back(name);
    }
    if (error) return FileError("list", path_, error.value());
    std::sort(names.begin(), names.end());
    return names;
  }

  absl::StatusOr<uint64_t> Size(const std::string& name) override {
    struct stat about;
    if (stat(PathOf(name).c_str(), &about) != 0) return FileError("stat", PathOf(name), errno);
    return static_cast<uint64_t>(about.st_size);
  }

  absl::StatusOr<std::string> Read(const std::string& name, uint64_t offset,
                                   size_t bytes) override {
    const Descriptor file(open(PathOf(name).c_str(), O_RDONLY | O_CLOEXEC));
    if (file.fd() < 0) return ReadError(PathOf(name), errno);
    std::string content(bytes, '\0');
    size_t done = 0;
    while (done < bytes) {
      const ssize_t got =
          pread(file.fd(), content.data() + done, bytes - done, static_cast<off_t>(offset + done));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return ReadError(PathOf(name), errno);
      if (got == 0) break;
      done += static_cast<size_t>(got);
    }
    content.resize(done);
    return content;
  }

  absl::Status Append(const std::string& name, absl::string_view bytes) override {
    ASSIGN_OR_RETURN(const Descriptor file, OpenFile(PathOf(name), O_WRONLY | O_CREAT | O_APPEND));
    while (!bytes.empty()) {
      const ssize_t put = write(file.fd(), bytes.data(), bytes.size());
      if (put < 0 && errno == EINTR) continue;
      if (put < 0) return FileError("write", PathOf(name), errno);
      bytes.remove_prefix(static_cast<size_t>(put));
    }
    return absl::OkStatus();
  }

  absl::Status Truncate(const std::string& name, uint64_t size) override {
    if (truncate(PathOf(name).c_str(), static_cast<off_t>(size)) == 0) return absl::OkStatus();
    return FileError("truncate", PathOf(name), errno);
  }

  absl::Status Sync(const std::string& name) override {
    {
      ASSIGN_OR_RETURN(const Descriptor file, OpenFile(PathOf(name), O_WRONLY));
      if (fdatasync(file.fd()) != 0) return FileError("sync", PathOf(name), errno);
    }
    {
      absl::MutexLock lock(&mutex_);
      if (named_.contains(name)) return absl::OkStatus();
    }
    // The folder is synced, too, for the file's name.
    RETURN_IF_ERROR(SyncFolder(path_));
    absl::MutexLock lock(&mutex_);
    named_.insert(name);
    return absl::OkStatus();
  }

  absl::Status Remove(const std::string& name) override {
    {
      absl::MutexLock lock(&mutex_);
      named_.erase(name);
    }
    if (unlink(PathOf(name).c_str()) == 0) return absl::OkStatus();
    return FileError("remove", PathOf(name), errno);
  }

 private:
  std::string PathOf(const std::string& name) const { return absl::StrCat(path_, "/", name); }

  const std::string path_;
  const Descriptor lock_;
  absl::Mutex mutex_;
  // Files whose names are on the disk for certain.
  absl::flat_hash_set<std::string> named_ ABSL_GUARDED_BY(mutex_);
};

// Creates the folder and those above it that are not there.
absl::Status CreateFolder(const std::string& path) {
  std::error_code error;
  std::vector<std::filesystem::path> created;
  std::filesystem::path missing = std::filesystem::absolute(path, error).lexically_normal();
  for (; !error && !missing.empty() && !std::filesystem::exists(missing, error);
       missing = missing.parent_path()) {
    created.push_back(missing);
  }
  if (!error) std::filesystem::create_directories(path, error);
  if (error) return FileError("create", path, error.value());
  for (const std::filesystem::path& folder : created) {
    RETURN_IF_ERROR(SyncFolder(folder.parent_path().string()));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<SpoolFiles>> OpenSpoolFolder(const std::string& path) {
  RETURN_IF_ERROR(CreateFolder(path));
  const std::string lock_path = absl::StrCat(path, "/", kLockName);
  ASSIGN_OR_RETURN(Descriptor lock, OpenFile(lock_path, O_RDWR | O_CREAT));
  if (flock(lock.fd(), LOCK_EX | LOCK_NB) != 0) {
    return absl::FailedPreconditionError(
        absl::StrCat("the spool folder ", path, " is in use: ", DescribeLockHolder(lock_path),
                     "; stop it, or give each robot a folder of its own"));
  }
  return std::make_unique<SpoolFolder>(path, std::move(lock));
}

}  // namespace corbslam::client_agent
