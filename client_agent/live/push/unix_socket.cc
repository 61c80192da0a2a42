#include "client_agent/live/push/unix_socket.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr int kWaiting = 8;  // Connections that wait to be accepted.
constexpr mode_t kMode = 0660;
constexpr size_t kMostFiles = 4;

UniqueFd NewSocket() {
  return UniqueFd(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

absl::StatusOr<sockaddr_un> AddressOf(const std::string& path) {
  sockaddr_un address = {};
  if (path.empty() || path.size() >= sizeof(address.sun_path)) {
    return absl::InvalidArgumentError(absl::StrCat("push:", path, ": a socket's path has 1 to ",
                                                   sizeof(address.sun_path) - 1, " bytes"));
  }
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), path.size());
  return address;
}

absl::Status Failed(const std::string& path, absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat("push:", path, ": ", what, ": ", std::strerror(errno)));
}

const sockaddr* Generic(const sockaddr_un& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}

// Returns true where a socket lies there that nobody listens at.
absl::StatusOr<bool> IsLeftBehind(const std::string& path, const sockaddr_un& address) {
  struct stat about = {};
  if (lstat(path.c_str(), &about) != 0) {
    if (errno == ENOENT) return false;
    return Failed(path, "can't be looked at");
  }
  if (!S_ISSOCK(about.st_mode)) {
    return absl::InvalidArgumentError(
        absl::StrCat("push:", path, ": is there, and is no socket: name another path"));
  }
  const UniqueFd trial = NewSocket();
  if (connect(trial.get(), Generic(address), sizeof(address)) != 0 && errno == ECONNREFUSED) {
    return true;
  }
  return absl::AlreadyExistsError(absl::StrCat(
      "push:", path, ": another program listens there: stop it, or name another path"));
}

void TakeFiles(msghdr& message, std::vector<UniqueFd>& files) {
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr;
       part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_RIGHTS) continue;
    const size_t count = (part->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (size_t i = 0; i < count; ++i) {
      int fd = -1;
      std::memcpy(&fd, CMSG_DATA(part) + i * sizeof(int), sizeof(int));
      files.emplace_back(fd);
    }
  }
}

}  // namespace

UniqueFd::~UniqueFd() {
  if (fd_ >= 0) close(fd_);
}

absl::Status UnixListener::Check(const std::string& path) {
  ASSIGN_OR_RETURN(const sockaddr_un address, AddressOf(path));
  RETURN_IF_ERROR(IsLeftBehind(path, address).status());
  const size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  if (access(folder.c_str(), W_OK | X_OK) != 0) return Failed(path, "its folder can't be used");
  return absl::OkStatus();
}

absl::StatusOr<UnixListener> UnixListener::Listen(const std::string& path) {
  ASSIGN_OR_RETURN(const sockaddr_un address, AddressOf(path));
  ASSIGN_OR_RETURN(const bool left_behind, IsLeftBehind(path, address));
  if (left_behind && unlink(path.c_str()) != 0) return Failed(path, "can't be removed");
  UniqueFd socket = NewSocket();
  if (bind(socket.get(), Generic(address), sizeof(address)) != 0) {
    return Failed(path, "no socket can be made there");
  }
  UnixListener listener(std::move(socket), path);
  if (chmod(path.c_str(), kMode) != 0) return Failed(path, "its mode can't be set");
  if (listen(listener.fd(), kWaiting) != 0) return Failed(path, "can't be listened at");
  return listener;
}

UnixListener::~UnixListener() {
  if (socket_.get() >= 0) unlink(path_.c_str());
}

std::optional<UniqueFd> UnixListener::Accept() const {
  UniqueFd accepted(accept4(fd(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (accepted.get() < 0) return std::nullopt;
  return accepted;
}

absl::StatusOr<std::optional<Packet>> ReceivePacket(int socket, size_t most_bytes) {
  Packet packet;
  packet.bytes.resize(most_bytes);
  alignas(cmsghdr) char control[CMSG_SPACE(kMostFiles * sizeof(int))];
  iovec part = {packet.bytes.data(), packet.bytes.size()};
  msghdr message = {};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof(control);
  ssize_t bytes = recvmsg(socket, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  // The other side ended before it read all: said once, before what it had sent until then.
  if (bytes < 0 && errno == ECONNRESET) {
    bytes = recvmsg(socket, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  }
  if (bytes < 0 && (errno == EAGAIN || errno == EINTR)) return std::nullopt;
  if (bytes < 0) return absl::UnavailableError(std::strerror(errno));
  TakeFiles(message, packet.files);
  // An empty packet and the other side's end look the same, and both end it.
  if (bytes == 0) return absl::UnavailableError("it closed the connection");
  packet.bytes.resize(static_cast<size_t>(bytes));
  packet.is_cut = (message.msg_flags & (MSG_TRUNC | MSG_CTRUNC)) != 0;
  return packet;
}

absl::StatusOr<bool> SendPacket(int socket, absl::string_view bytes) {
  while (send(socket, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL) < 0) {
    if (errno == EINTR) continue;
    if (errno == EAGAIN) return false;
    return absl::UnavailableError(std::strerror(errno));
  }
  return true;
}

std::string PeerOf(int socket) {
  ucred who = {};
  socklen_t bytes = sizeof(who);
  if (getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &who, &bytes) != 0 || who.pid <= 0) {
    return "a process";
  }
  return absl::StrCat("process ", who.pid);
}

}  // namespace corbslam::client_agent
