// Decides about calls: who calls, by certificate or token, and whether the policy allows it.
#ifndef CORBSLAM_SERVICES_SECURITY_ACCESS_CONTROL_H_
#define CORBSLAM_SERVICES_SECURITY_ACCESS_CONTROL_H_

#include <grpcpp/security/auth_metadata_processor.h>
#include <grpcpp/server_context.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "services/security/identity.h"
#include "services/security/policy.h"
#include "services/security/token.h"

namespace corbslam::services {

// Holds what a caller shows.
struct Evidence {
  std::vector<std::string> uris;  // Names in a certificate that TLS has verified.
  std::optional<std::string> authorization;
};
Evidence EvidenceOf(const grpc::CallbackServerContext& context);

struct AccessControlOptions {
  // Nullopt: tokens are refused.
  std::optional<TokenVerifier> tokens;
  // True: callers without an identity may ask for health, too.
  bool health_is_open = true;
  // The mission of all that this server tells (an agent's own service). Nullopt: requests name it.
  std::optional<std::string> mission;
  // The agent whose own service it is.
  std::optional<std::string> agent;
};

// Knows who may call what. Immutable, thread-safe.
class AccessControl {
 public:
  explicit AccessControl(const AccessControlOptions& options) : options_(options) {}

  // Returns who the caller is. A token, if one is shown, counts instead of the certificate: a good
  // certificate never makes up for a bad token. UNAUTHENTICATED if neither is shown.
  absl::StatusOr<Identity> Identify(const Evidence& evidence, absl::Time now) const;

  // Checks, before a call's request is read, whether the caller may call this method at all.
  absl::Status CheckMethod(absl::string_view path, const Evidence& evidence, absl::Time now) const;
  // Checks the access once the request has named the mission.
  absl::Status Check(const Access& access, const Evidence& evidence, absl::Time now) const;

 private:
  const AccessControlOptions options_;
};

// Makes a processor that asks `access` about every call before its handler runs, calls of gRPC's
// own services included.
std::shared_ptr<grpc::AuthMetadataProcessor> MakeCallGate(
    std::shared_ptr<const AccessControl> access);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_ACCESS_CONTROL_H_
