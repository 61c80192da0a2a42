#include "client_agent/source/bag/files/bag_bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"

namespace corbslam::client_agent {

absl::StatusOr<std::unique_ptr<const BagBytes>> BagBytes::Open(const std::string& path,
                                                               const std::string& name) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return absl::NotFoundError(absl::StrCat(name, ": ", std::strerror(errno)));
  struct stat state = {};
  if (fstat(file, &state) != 0 || !S_ISREG(state.st_mode)) {
    close(file);
    return absl::InvalidArgumentError(absl::StrCat(name, ": no file that can be read"));
  }
  return std::unique_ptr<const BagBytes>(
      new BagBytes(name, file, static_cast<uint64_t>(state.st_size)));
}

BagBytes::BagBytes(std::string name, int file, uint64_t size)
    : name_(std::move(name)), file_(file), size_(size) {}

BagBytes::BagBytes(std::string name, std::string bytes)
    : name_(std::move(name)), memory_(std::move(bytes)), size_(memory_.size()) {}

BagBytes::~BagBytes() {
  if (file_ >= 0) close(file_);
}

absl::Status BagBytes::ErrorAt(uint64_t offset, absl::string_view what) const {
  return absl::InvalidArgumentError(absl::StrCat(name_, ": at ", offset, ": ", what));
}

absl::StatusOr<std::string> BagBytes::Read(uint64_t offset, uint64_t count,
                                           absl::string_view what) const {
  if (offset > size_ || count > size_ - offset) {
    return ErrorAt(offset, absl::StrCat(what, " has ", count, " bytes, ",
                                        size_ - std::min(offset, size_), " are there"));
  }
  if (count > kMostBagBytes) {
    return ErrorAt(
        offset, absl::StrCat(what, " has ", count, " bytes, at most ", kMostBagBytes, " are read"));
  }
  return ReadUpTo(offset, count);
}

absl::StatusOr<std::string> BagBytes::ReadUpTo(uint64_t offset, uint64_t count) const {
  const uint64_t begin = std::min(offset, size_);
  const uint64_t wanted = std::min({count, size_ - begin, kMostBagBytes});
  if (file_ < 0) return memory_.substr(begin, wanted);
  std::string bytes(wanted, '\0');
  uint64_t done = 0;
  while (done < wanted) {
    const ssize_t got =
        pread(file_, bytes.data() + done, wanted - done, static_cast<off_t>(begin + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) {
      return ErrorAt(begin + done, got == 0 ? "the file was cut short" : std::strerror(errno));
    }
    done += static_cast<uint64_t>(got);
  }
  return bytes;
}

}  // namespace corbslam::client_agent
