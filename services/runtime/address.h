// Parses addresses of servers, as people write them into flags.
#ifndef CORBSLAM_SERVICES_RUNTIME_ADDRESS_H_
#define CORBSLAM_SERVICES_RUNTIME_ADDRESS_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam::services {

struct HostPort {
  std::string host;  // Without the brackets of an IPv6 address.
  int port = 0;
};

// Parses what a server is to listen on: HOST:PORT, an IPv6 address in brackets. Port 0 means that
// the system chooses one, no host means all addresses of the machine. INVALID_ARGUMENT says what is
// wrong and how it is written right. gRPC's own check would not do: it takes ports modulo 65536,
// and a bare IPv6 address for a host without a port.
absl::StatusOr<HostPort> ParseListenAddress(absl::string_view address);

// Parses what a client is to connect to: likewise, with a host and a port that is not 0. It accepts
// gRPC's names dns:///HOST:PORT, dns:HOST:PORT, ipv4:HOST:PORT and ipv6:[HOST]:PORT, too, and
// refuses any other scheme.
absl::StatusOr<HostPort> ParseServerAddress(absl::string_view address);

// Writes HOST:PORT again, for people.
std::string ToString(const HostPort& address);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_RUNTIME_ADDRESS_H_
