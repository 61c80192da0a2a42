// Decides about calls: who calls, by certificate or token, and whether the policy allows it.
#ifndef CORBSLAM_SERVICES_SECURITY_ACCESS_CONTROL_H_
#define CORBSLAM_SERVICES_SECURITY_ACCESS_CONTROL_H_

#include <grpcpp/security/auth_metadata_processor.h>
#include <grpcpp/server_context.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "services/security/identity.h"
#include "services/security/policy.h"
#include "services/security/revoked_list.h"
#include "services/security/token.h"
#include "services/server/door.h"

namespace corbslam::services {

// Holds what a caller shows.
struct Evidence {
  std::vector<std::string> uris;  // Names in a certificate that TLS has verified.
  std::optional<std::string> authorization;
};
Evidence EvidenceOf(const grpc::ServerContextBase& context);

struct AccessControlOptions {
  // Nullopt: tokens are refused.
  std::optional<TokenVerifier> tokens;
  // Identities that are refused.
  RevokedList revoked = {};
  // The server's name: a token that is for another one is refused, and so is every token that is
  // for one, if this is empty.
  std::string audience = {};
  // A token that is good for longer is refused: from when it was issued or, if it does not say so,
  // from when it is shown.
  absl::Duration max_token_lifetime = absl::InfiniteDuration();
  // True: callers without an identity may ask for health, too.
  bool health_is_open = true;
  // The mission of all that this server tells (an agent's own service). Nullopt: requests name it.
  std::optional<std::string> mission;
  // The agent whose own service it is.
  std::optional<std::string> agent;
};

// Knows who may call what. Thread-safe.
class AccessControl : public Door {
 public:
  explicit AccessControl(const AccessControlOptions& options)
      : options_(options),
        rules_(std::make_shared<const Rules>(Rules{options.tokens, options.revoked})) {}

  // Returns who the caller is. A token, if one is shown, counts instead of the certificate: a good
  // certificate never makes up for a bad token. UNAUTHENTICATED if neither is shown.
  absl::StatusOr<Identity> Identify(const Evidence& evidence, absl::Time now) const;

  // Checks, before a call's request is read, whether the caller may call this method at all.
  absl::Status CheckMethod(absl::string_view path, const Evidence& evidence, absl::Time now) const;
  // Checks whether the caller may have this access.
  absl::Status Check(const Access& access, const Evidence& evidence, absl::Time now) const;
  // Checks, once it is known what a call asks for, what stands at it in the proto: for each mission
  // that the message names. INVALID_ARGUMENT for a name that can't be read.
  absl::Status Check(const google::protobuf::MethodDescriptor& method,
                     const grpc::ServerContextBase& context,
                     const google::protobuf::Message& message) const override;
  std::shared_ptr<const KnownCaller> Meet(const grpc::ServerContextBase& context) const override;
  // Returns UNAUTHENTICATED, naming what, once the identity is revoked; a token that has expired,
  // or whose key is gone, is none of that: a stream that is open stays so.
  absl::Status CheckNotRevoked(const Identity& identity) const;

  // Replace what calls are decided by from now on.
  void SetTokens(TokenVerifier tokens) ABSL_LOCKS_EXCLUDED(mutex_);
  void SetRevoked(RevokedList revoked) ABSL_LOCKS_EXCLUDED(mutex_);
  // `listener` is called after each SetRevoked, by its thread.
  void OnRevoked(std::function<void()> listener) const override ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  // What changes while the server runs.
  struct Rules {
    std::optional<TokenVerifier> tokens;
    RevokedList revoked;
  };

  std::shared_ptr<const Rules> rules() const ABSL_LOCKS_EXCLUDED(mutex_);
  absl::StatusOr<Identity> IdentifyToken(absl::string_view token, const Rules& rules,
                                         absl::Time now) const;
  absl::Status CheckClaims(const TokenClaims& claims, absl::Time now) const;

  const AccessControlOptions options_;
  mutable absl::Mutex mutex_;
  std::shared_ptr<const Rules> rules_ ABSL_GUARDED_BY(mutex_);
  mutable std::vector<std::function<void()>> listeners_ ABSL_GUARDED_BY(mutex_);
};

// Hears of a call that the gate has refused, of what its caller showed and what it calls itself
// (its user agent).
using TurnedAwayListener =
    std::function<void(absl::string_view method, const Evidence& evidence,
                       absl::string_view user_agent, const absl::Status& status)>;

// Makes a processor that asks `access` about every call before its handler runs, calls of gRPC's
// own services included. `on_turned_away` may be null.
std::shared_ptr<grpc::AuthMetadataProcessor> MakeCallGate(
    std::shared_ptr<const AccessControl> access, TurnedAwayListener on_turned_away = nullptr);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_ACCESS_CONTROL_H_
