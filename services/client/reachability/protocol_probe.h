// Which language a server speaks that somebody reached without TLS.
#ifndef CORBSLAM_SERVICES_CLIENT_REACHABILITY_PROTOCOL_PROBE_H_
#define CORBSLAM_SERVICES_CLIENT_REACHABILITY_PROTOCOL_PROBE_H_

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "services/runtime/address.h"

namespace corbslam {

enum class Protocol {
  kHttp2,   // What gRPC speaks, without TLS.
  kHttp1,   // A web server: perhaps one that serves metrics.
  kTls,     // It complains in TLS.
  kClosed,  // It hangs up. Servers with TLS do so when they are spoken to without.
  kSilent,  // It says nothing in time.
  kOther,   // It says something else.
};

// Greets the server as a gRPC client without TLS does, and looks at how its answer begins. Errors
// are those of Connect.
absl::StatusOr<Protocol> ProbeProtocol(const HostPort& address, absl::Duration timeout);

// What the first bytes of an answer are; of none: kClosed.
Protocol ClassifyAnswer(absl::string_view bytes);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_CLIENT_REACHABILITY_PROTOCOL_PROBE_H_
