// Finds out step by step why a server is not reached.
#ifndef CORBSLAM_SERVICES_CLIENT_REACHABILITY_CAUSE_H_
#define CORBSLAM_SERVICES_CLIENT_REACHABILITY_CAUSE_H_

#include <grpcpp/channel.h>

#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "services/security/security_options.h"

namespace corbslam::services {

// Names of our services, as reflection spells them.
inline constexpr char kMapStoreService[] = "corbslam.v1.MapStore";
inline constexpr char kFusionWorkerService[] = "corbslam.v1.FusionWorker";

// Says where a client wants to go.
struct ServerTarget {
  std::string address;  // In the form that ParseServerAddress takes.
  std::string service;  // For example "corbslam.v1.MapStore".
  SecurityOptions security;
};

struct Cause {
  std::string text;    // What is wrong: "nothing listens there: Connection refused".
  std::string advice;  // What to do.
  // True: waiting can't help, unless somebody does something. False: the network or the server may
  // be slow.
  bool is_certain = true;
  // True if the address itself is no address.
  bool is_bad_address = false;
  // True if it is this side's certificate, key or authorities: the server is not asked.
  bool is_own = false;
};

// Returns "no map store answers at 127.0.0.1:1: TEXT; ADVICE", as INVALID_ARGUMENT for a bad
// address, else as UNAVAILABLE.
absl::Status ToStatus(const ServerTarget& target, const Cause& cause);

// Returns what people call the service: "map store".
std::string NameOfService(const std::string& service);

// Each step looks at what the steps before it left, and returns nullopt if nothing is wrong there.
// All steps block, for about `patience` each, and are thread-safe.

// Checks the address and a proxy in the way, then whether somebody listens.
std::optional<Cause> FindCauseOfWay(const ServerTarget& target, absl::Duration patience);
// Finds TLS on one side only, a certificate that is not the one wanted, and a server without gRPC.
std::optional<Cause> FindCauseOfTransport(const ServerTarget& target, absl::Duration patience);
// Finds that another server answers than the one wanted. It asks the server's reflection, and
// returns nullopt if that is off.
std::optional<Cause> FindCauseOfService(const ServerTarget& target,
                                        const std::shared_ptr<grpc::Channel>& channel,
                                        absl::Duration patience);

// Takes all steps, over a channel of its own. That takes about a second, unless the server or the
// network is slow at every step.
std::optional<Cause> FindCause(const ServerTarget& target,
                               absl::Duration patience = absl::Seconds(1));

// Explains how a call ended, where OK means that it does not end. Returns the cause if the
// transport failed and a cause is found, else `seen` itself.
absl::Status ExplainFailure(const ServerTarget& target, const absl::Status& seen);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_REACHABILITY_CAUSE_H_
