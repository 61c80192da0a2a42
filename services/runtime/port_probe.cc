#include "services/runtime/port_probe.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/runtime/address.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

class Socket {
 public:
  explicit Socket(int family)
      : fd_(socket(family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {}
  ~Socket() {
    if (fd_ >= 0) close(fd_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  int fd() const { return fd_; }

 private:
  const int fd_;
};

// Returns an address by which this machine reaches the one that is listened on.
std::string Reachable(const std::string& host) {
  if (host.empty() || host == "0.0.0.0") return "127.0.0.1";
  return host == "::" ? "::1" : host;
}

absl::Status Failed(absl::string_view action, int error) {
  return absl::UnavailableError(absl::StrCat("can't ", action, ": ", std::strerror(error)));
}

// Waits for what poll() calls `event`, or for the connection's end.
absl::Status Await(int fd, short event, absl::Time deadline, absl::string_view what) {
  while (true) {
    pollfd waited = {.fd = fd, .events = event, .revents = 0};
    const absl::Duration left = std::max(deadline - absl::Now(), absl::ZeroDuration());
    const int ready = poll(&waited, 1, static_cast<int>(absl::ToInt64Milliseconds(left)) + 1);
    if (ready > 0) return absl::OkStatus();
    if (ready < 0 && errno != EINTR) return Failed("wait", errno);
    if (absl::Now() >= deadline) return absl::DeadlineExceededError(absl::StrCat("no ", what));
  }
}

absl::Status Connect(int fd, const addrinfo& address, absl::Time deadline) {
  if (connect(fd, address.ai_addr, address.ai_addrlen) == 0) return absl::OkStatus();
  if (errno != EINPROGRESS) return Failed("connect", errno);
  RETURN_IF_ERROR(Await(fd, POLLOUT, deadline, "connection"));
  int error = 0;
  socklen_t length = sizeof(error);
  getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &length);
  return error == 0 ? absl::OkStatus() : Failed("connect", error);
}

absl::Status Probe(const std::string& address, absl::Duration patience) {
  const absl::Time deadline = absl::Now() + patience;
  ASSIGN_OR_RETURN(const HostPort parsed, ParseListenAddress(address));
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
  addrinfo* list = nullptr;
  const int error =
      getaddrinfo(Reachable(parsed.host).c_str(), absl::StrCat(parsed.port).c_str(), &hints, &list);
  if (error != 0) return absl::InvalidArgumentError(gai_strerror(error));
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> found(list, freeaddrinfo);
  const Socket socket(found->ai_family);
  if (socket.fd() < 0) return Failed("make a socket", errno);
  RETURN_IF_ERROR(Connect(socket.fd(), *found, deadline));
  // A server that reads it waits for more, and learns that no more comes.
  if (send(socket.fd(), "P", 1, MSG_NOSIGNAL) != 1) return Failed("write", errno);
  shutdown(socket.fd(), SHUT_WR);
  return Await(socket.fd(), POLLIN, deadline, "answer");
}

}  // namespace

absl::Status ProbePort(const std::string& address, absl::Duration patience) {
  const absl::Status status = Probe(address, patience);
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrCat("a connection of this process itself to ",
                                                  address, " failed: ", status.message(),
                                                  " within ", absl::FormatDuration(patience)));
}

}  // namespace corbslam::services
