// Finds out whether a server of this process still takes connections.
#ifndef CORBSLAM_SERVICES_RUNTIME_PORT_PROBE_H_
#define CORBSLAM_SERVICES_RUNTIME_PORT_PROBE_H_

#include <string>

#include "absl/status/status.h"
#include "absl/time/time.h"

namespace corbslam::services {

// Connects to a server of this machine that listens on "IP:PORT" (an IPv6 address in brackets, one
// for all addresses too), says less than any protocol's first word, and waits for an answer or for
// the connection's end: either shows that somebody accepted and read. DEADLINE_EXCEEDED if neither
// comes within `patience`, UNAVAILABLE if there is no connection, with why.
absl::Status ProbePort(const std::string& address, absl::Duration patience);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_RUNTIME_PORT_PROBE_H_
