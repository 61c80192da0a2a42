// Connects to a server and says why it can't.
#ifndef CORBSLAM_SERVICES_CLIENT_REACHABILITY_TCP_PROBE_H_
#define CORBSLAM_SERVICES_CLIENT_REACHABILITY_TCP_PROBE_H_

#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "services/runtime/address.h"

namespace corbslam::services {

// Owns an open connection and closes it when it is destroyed.
class Connection {
 public:
  explicit Connection(int socket) : socket_(socket) {}
  ~Connection();
  Connection(Connection&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}
  Connection& operator=(Connection&&) = delete;

  int socket() const { return socket_; }
  // Makes later calls on the socket wait, for at most `timeout`.
  void MakeBlocking(absl::Duration timeout) const;

 private:
  int socket_;
};

// Tries the host's addresses one after the other, looking up and connecting for `timeout` each.
// NOT_FOUND if there is no such host; UNAVAILABLE with what the network said, "Connection refused";
// DEADLINE_EXCEEDED if the look-up or the connection got no answer: the message says which.
absl::StatusOr<Connection> Connect(const HostPort& address, absl::Duration timeout);

// Checks whether somebody listens at the address. Errors are those of Connect.
absl::Status ProbeTcp(const HostPort& address, absl::Duration timeout);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_REACHABILITY_TCP_PROBE_H_
