#include "services/security/key_material.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"

namespace corbslam::services {
namespace {

// gRPC looks at the files so often, in seconds.
constexpr unsigned kPollInterval_s = 1;

absl::Status NoMemoryFile() {
  return absl::ResourceExhaustedError(
      absl::StrCat("no file in memory for a certificate: ", std::strerror(errno)));
}

bool WriteAll(int file, absl::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(file, text.data(), text.size());
    if (written <= 0) return false;
    text.remove_prefix(static_cast<size_t>(written));
  }
  return true;
}

}  // namespace

MemoryFile::~MemoryFile() {
  if (file_ >= 0) close(file_);
}

absl::Status MemoryFile::Replace(absl::string_view text) {
  const int fresh = memfd_create("corbslam-certificate", MFD_CLOEXEC);
  if (fresh < 0) return NoMemoryFile();
  // gRPC tells by the time, in whole seconds, whether key and certificate are of one reading.
  const int64_t modified_s = std::max(modified_s_ + 1, absl::ToUnixSeconds(absl::Now()));
  const timespec times[2] = {{modified_s, 0}, {modified_s, 0}};
  const bool good = WriteAll(fresh, text) && futimens(fresh, times) == 0 &&
                    (file_ < 0 || dup3(fresh, file_, O_CLOEXEC) >= 0);
  if (!good) {
    const absl::Status status = NoMemoryFile();
    close(fresh);
    return status;
  }
  if (file_ < 0) {
    file_ = fresh;
  } else {
    close(fresh);
  }
  modified_s_ = modified_s;
  return absl::OkStatus();
}

std::string MemoryFile::path() const {
  return file_ < 0 ? "" : absl::StrCat("/proc/self/fd/", file_);
}

absl::Status KeyMaterial::SetPair(absl::string_view key_and_certificate_pem) {
  return pair_.Replace(key_and_certificate_pem);
}

absl::Status KeyMaterial::SetAuthorities(absl::string_view pem) {
  return authorities_.Replace(pem);
}

std::shared_ptr<grpc::experimental::CertificateProviderInterface> KeyMaterial::MakeProvider()
    const {
  return std::make_shared<grpc::experimental::FileWatcherCertificateProvider>(
      pair_.path(), pair_.path(), authorities_.path(), kPollInterval_s);
}

}  // namespace corbslam::services
