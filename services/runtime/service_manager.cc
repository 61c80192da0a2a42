#include "services/runtime/service_manager.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "absl/strings/numbers.h"

namespace corbslam::services {
namespace {

// Returns the length of the address; 0: the path is none.
socklen_t FillAddress(const char* path, sockaddr_un& address) {
  const size_t length = std::strlen(path);
  const bool is_path = path[0] == '/' || path[0] == '@';
  if (!is_path || length < 2 || length >= sizeof(address.sun_path)) return 0;
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path, length);
  // A name without a file begins with a zero.
  if (path[0] == '@') address.sun_path[0] = '\0';
  return static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + length);
}

}  // namespace

bool NotifyServiceManager(absl::string_view lines) {
  const char* const path = std::getenv("NOTIFY_SOCKET");
  if (path == nullptr) return false;
  sockaddr_un address = {};
  const socklen_t length = FillAddress(path, address);
  if (length == 0) return false;
  const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  const ssize_t sent = sendto(fd, lines.data(), lines.size(), MSG_NOSIGNAL,
                              reinterpret_cast<const sockaddr*>(&address), length);
  close(fd);
  return sent == static_cast<ssize_t>(lines.size());
}

absl::Duration WatchdogTimeout() {
  const char* const timeout = std::getenv("WATCHDOG_USEC");
  const char* const process = std::getenv("WATCHDOG_PID");
  int64_t timeout_us = 0;
  if (timeout == nullptr || !absl::SimpleAtoi(timeout, &timeout_us) || timeout_us <= 0) {
    return absl::InfiniteDuration();
  }
  // The variables are inherited by children, who are not meant.
  int64_t pid = 0;
  if (process != nullptr && (!absl::SimpleAtoi(process, &pid) || pid != getpid())) {
    return absl::InfiniteDuration();
  }
  return absl::Microseconds(timeout_us);
}

}  // namespace corbslam::services
