// Why a server is not reached, found out step by step.
#ifndef CORBSLAM_SERVICES_CLIENT_REACHABILITY_CAUSE_H_
#define CORBSLAM_SERVICES_CLIENT_REACHABILITY_CAUSE_H_

#include <grpcpp/channel.h>

#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "services/security/security_options.h"

namespace corbslam {

// Names of our services, as reflection has them.
inline constexpr char kMapStoreService[] = "corbslam.v1.MapStore";
inline constexpr char kFusionWorkerService[] = "corbslam.v1.FusionWorker";

// Where a client wants to go.
struct ServerTarget {
  std::string address;  // As ParseServerAddress takes it.
  std::string service;  // As "corbslam.v1.MapStore".
  SecurityOptions security;
};

struct Cause {
  std::string text;    // What is so: "nothing listens there: Connection refused".
  std::string advice;  // What to do.
  // Waiting can't help, unless somebody does something. False: the network or the server may be
  // slow.
  bool is_certain = true;
  // The address itself is no address.
  bool is_bad_address = false;
};

// "map store 127.0.0.1:1 is not reached: TEXT; ADVICE", INVALID_ARGUMENT for a bad address, else
// UNAVAILABLE.
absl::Status ToStatus(const ServerTarget& target, const Cause& cause);

// What people call the service: "map store".
std::string NameOfService(const std::string& service);

// Each step looks at what the ones before left; none: nothing is wrong there. All block, about
// `patience` each, and are thread-safe.

// The address and a proxy in the way; then whether somebody listens.
std::optional<Cause> FindCauseOfWay(const ServerTarget& target, absl::Duration patience);
// TLS on one side only, a certificate that is not the one wanted, no gRPC at all.
std::optional<Cause> FindCauseOfTransport(const ServerTarget& target, absl::Duration patience);
// Who answers is another server than the one wanted. Asks its reflection; none where that is off.
std::optional<Cause> FindCauseOfService(const ServerTarget& target,
                                        const std::shared_ptr<grpc::Channel>& channel,
                                        absl::Duration patience);

// All steps, over a channel of its own. Takes about a second, unless the server or the network is
// slow at every step.
std::optional<Cause> FindCause(const ServerTarget& target,
                               absl::Duration patience = absl::Seconds(1));

// How a call ended (OK: it does not end), with the cause where the transport failed; else, and
// where none is found, `seen` itself.
absl::Status ExplainFailure(const ServerTarget& target, const absl::Status& seen);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_CLIENT_REACHABILITY_CAUSE_H_
