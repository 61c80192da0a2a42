#include "services/client/reachability/tcp_probe.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "services/client/reachability/host_lookup.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Returns 0 once the socket is connected, else errno.
int WaitUntilConnected(int socket, absl::Duration timeout) {
  pollfd entry = {socket, POLLOUT, 0};
  if (poll(&entry, 1, static_cast<int>(absl::ToInt64Milliseconds(timeout))) != 1) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof(error);
  getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

// Returns a connected socket, or minus errno.
int ConnectOne(const SocketAddress& target, absl::Duration timeout) {
  const int connection =
      socket(target.bytes.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (connection < 0) return -errno;
  int error = 0;
  if (connect(connection, reinterpret_cast<const sockaddr*>(&target.bytes), target.size) != 0) {
    error = errno == EINPROGRESS ? WaitUntilConnected(connection, timeout) : errno;
  }
  if (error == 0) return connection;
  close(connection);
  return -error;
}

absl::Status ToStatus(int error, absl::Duration timeout) {
  if (error != ETIMEDOUT) return absl::UnavailableError(std::strerror(error));
  return absl::DeadlineExceededError(
      absl::StrCat("nothing answers within ", absl::FormatDuration(timeout)));
}

}  // namespace

Connection::~Connection() {
  if (socket_ >= 0) close(socket_);
}

void Connection::MakeBlocking(absl::Duration timeout) const {
  fcntl(socket_, F_SETFL, fcntl(socket_, F_GETFL) & ~O_NONBLOCK);
  const timeval limit = absl::ToTimeval(timeout);
  setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof(limit));
  setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof(limit));
}

absl::StatusOr<Connection> Connect(const HostPort& address, absl::Duration timeout) {
  const absl::StatusOr<std::vector<SocketAddress>> targets = LookUpHost(address, timeout);
  if (absl::IsDeadlineExceeded(targets.status())) {
    return absl::DeadlineExceededError(absl::StrCat(
        "looking up ", address.host, " takes longer than ", absl::FormatDuration(timeout)));
  }
  RETURN_IF_ERROR(targets.status());
  int connection = -EHOSTUNREACH;
  for (const SocketAddress& target : *targets) {
    connection = ConnectOne(target, timeout);
    if (connection >= 0) return Connection(connection);
  }
  return ToStatus(-connection, timeout);
}

absl::Status ProbeTcp(const HostPort& address, absl::Duration timeout) {
  return Connect(address, timeout).status();
}

}  // namespace corbslam::services
