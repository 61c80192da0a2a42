// Sockets of one machine whose packets may carry files.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_PUSH_UNIX_SOCKET_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_PUSH_UNIX_SOCKET_H_

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam::client_agent {

// Closes what it holds.
class UniqueFd {
 public:
  explicit UniqueFd(int fd = -1) : fd_(fd) {}
  UniqueFd(UniqueFd&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  UniqueFd& operator=(UniqueFd&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~UniqueFd();
  int get() const { return fd_; }

 private:
  int fd_;
};

// A socket in the file system, which goes with this.
class UnixListener {
 public:
  // Takes the place of a socket that nobody listens at any more. INVALID_ARGUMENT names a path that
  // is too long or where something else is; ALREADY_EXISTS: another program listens there.
  static absl::StatusOr<UnixListener> Listen(const std::string& path);
  // Says whether Listen would succeed, and does nothing.
  static absl::Status Check(const std::string& path);
  UnixListener(UnixListener&&) = default;
  UnixListener& operator=(UnixListener&&) = delete;
  ~UnixListener();

  int fd() const { return socket_.get(); }
  // Returns who connected; nullopt where nobody did.
  std::optional<UniqueFd> Accept() const;

 private:
  UnixListener(UniqueFd socket, std::string path)
      : socket_(std::move(socket)), path_(std::move(path)) {}

  UniqueFd socket_;
  std::string path_;
};

struct Packet {
  std::string bytes;
  bool is_cut = false;  // It was longer than could be taken, or carried more files.
  std::vector<UniqueFd> files;
};

// Returns a packet of at most `most_bytes`; nullopt where none is there. UNAVAILABLE: the other
// side went away.
absl::StatusOr<std::optional<Packet>> ReceivePacket(int socket, size_t most_bytes);

// Returns false where the other side takes nothing at the moment. UNAVAILABLE: it went away.
absl::StatusOr<bool> SendPacket(int socket, absl::string_view bytes);

// Returns "process 123", who connected; "a process" where that isn't known.
std::string PeerOf(int socket);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_PUSH_UNIX_SOCKET_H_
