// Finds out which protocol a server speaks that was reached without TLS.
#ifndef CORBSLAM_SERVICES_CLIENT_REACHABILITY_PROTOCOL_PROBE_H_
#define CORBSLAM_SERVICES_CLIENT_REACHABILITY_PROTOCOL_PROBE_H_

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "services/runtime/address.h"

namespace corbslam::services {

enum class Protocol {
  kHttp2,   // The server speaks what gRPC speaks without TLS.
  kHttp1,   // It is a web server: perhaps one that serves metrics.
  kTls,     // It complains in TLS.
  kClosed,  // It hangs up. Servers with TLS do so when they are spoken to without.
  kSilent,  // It says nothing in time.
  kOther,   // It says something else.
};

// Greets the server as a gRPC client without TLS does, and classifies the beginning of its answer.
// Errors are those of Connect.
absl::StatusOr<Protocol> ProbeProtocol(const HostPort& address, absl::Duration timeout);

// Returns the protocol by the first bytes of an answer; kClosed if there are none.
Protocol ClassifyAnswer(absl::string_view bytes);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_REACHABILITY_PROTOCOL_PROBE_H_
