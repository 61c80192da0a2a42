// Opens the sockets that a server listens on.
#ifndef CORBSLAM_SERVICES_SERVER_LISTENING_H_
#define CORBSLAM_SERVICES_SERVER_LISTENING_H_

#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"

namespace corbslam::services {

// Sockets that listen on one port. They are closed with it.
class Listening {
 public:
  Listening() = default;
  Listening(Listening&& other) noexcept
      : fds_(std::move(other.fds_)), port_(other.port_), reachable_(std::move(other.reachable_)) {
    other.fds_.clear();
  }
  ~Listening() { Close(); }
  Listening& operator=(Listening&&) = delete;

  // Listens on all addresses of the host in "HOST:PORT"; for port 0 the system chooses one. No
  // host, 0.0.0.0 and [::] mean all addresses of the machine. UNAVAILABLE: it can't, with why, and
  // who has the port.
  static absl::StatusOr<Listening> Open(const std::string& address);

  void Close();

  const std::vector<int>& fds() const { return fds_; }
  int port() const { return port_; }
  // Returns "IP:PORT" by which this machine reaches it.
  const std::string& reachable() const { return reachable_; }

 private:
  std::vector<int> fds_;
  int port_ = 0;
  std::string reachable_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_LISTENING_H_
