// Looks up the addresses of a host, and does not wait for ever.
#ifndef CORBSLAM_SERVICES_CLIENT_REACHABILITY_HOST_LOOKUP_H_
#define CORBSLAM_SERVICES_CLIENT_REACHABILITY_HOST_LOOKUP_H_

#include <sys/socket.h>

#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "services/runtime/address.h"

namespace corbslam::services {

struct SocketAddress {
  sockaddr_storage bytes = {};
  socklen_t size = 0;
};

// Finds the addresses of a host; it may take as long as it likes. NOT_FOUND if there is no such
// host, UNAVAILABLE if nobody can say.
using ResolveHost = std::function<absl::StatusOr<std::vector<SocketAddress>>(const HostPort&)>;

// Calls getaddrinfo, which reads /etc/hosts and asks DNS.
absl::StatusOr<std::vector<SocketAddress>> ResolveBySystem(const HostPort& address);

// Returns what `resolve` says, or DEADLINE_EXCEEDED when that takes longer than `timeout`. The
// look-up then goes on, on a thread of its own, and later callers for the same host wait for it:
// there is at most one thread for each host, however often a server that is not reached is asked
// for. Thread-safe.
absl::StatusOr<std::vector<SocketAddress>> LookUpHost(
    const HostPort& address, absl::Duration timeout, const ResolveHost& resolve = &ResolveBySystem);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_REACHABILITY_HOST_LOOKUP_H_
