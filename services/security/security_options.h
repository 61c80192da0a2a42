// Makes TLS and identities of our programs from the files that their flags name.
#ifndef CORBSLAM_SERVICES_SECURITY_SECURITY_OPTIONS_H_
#define CORBSLAM_SERVICES_SECURITY_SECURITY_OPTIONS_H_

#include <grpcpp/security/credentials.h>

#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "services/security/access_control.h"
#include "services/security/audit_log.h"
#include "services/server/server.h"

namespace corbslam::services {

struct SecurityOptions {
  // True: neither encryption nor identities; everybody may do everything.
  bool insecure = false;
  // This program's certificate (then those between it and the authority) and its key, as PEM.
  std::string certificate_file;
  std::string key_file;
  // Authorities whose certificates are trusted, as PEM.
  std::string ca_file;
  // For servers: public keys of the tokens that are accepted, as PEM.
  std::string token_key_file;
  // For servers: ids of tokens, and identities, that are refused
  // (services/security/revoked_list.h).
  std::string revoked_file;
  // For servers: AccessControlOptions has these two.
  std::string audience;
  absl::Duration max_token_lifetime = absl::InfiniteDuration();
  // For servers: AuditLogOptions has these two.
  std::string audit_file;
  uint64_t audit_bytes = AuditLogOptions().max_bytes;
  // For clients: the token to show. It is read again for each call, so that it can be replaced.
  std::string token_file;
  // True: a certificate, an authority, a key or a token that can't be used yet is no error. It is
  // said, nobody gets through, and the first content that is good is taken. A list of the revoked
  // must be good all the same.
  bool files_may_come = false;
  // These two are for servers.
  bool reflection = true;
  bool health_is_open = true;
};

// Returns what --insecure means.
inline SecurityOptions WithoutTls() {
  SecurityOptions options;
  options.insecure = true;
  return options;
}

struct ServerSecurity {
  // Null: everybody may do everything.
  std::shared_ptr<const AccessControl> access;
  ServerOptions server;
};

// Makes what a server needs: --insecure (logged as a warning), or a certificate, its key, and a way
// to tell who calls: authorities, whose certificates are then demanded, or token keys. A caller
// without a certificate gets as far as a call only where token keys are given or health is open.
// All the files are read again while the server lives (services/security/credential_watch.h): new
// contents count for new connections and calls, and no stream ends but those of the revoked.
// `mission` and `agent` are those of AccessControlOptions. INVALID_ARGUMENT says which flag is
// missing, what is wrong with which file, or which flags exclude each other.
absl::StatusOr<ServerSecurity> MakeServerSecurity(
    const SecurityOptions& options, const std::optional<std::string>& mission = std::nullopt,
    const std::optional<std::string>& agent = std::nullopt);

// Returns what MakeServerSecurity would refuse. Makes and changes no file: of the audit log's only
// the folder is looked at.
absl::Status CheckServerSecurity(const SecurityOptions& options,
                                 const std::optional<std::string>& mission = std::nullopt,
                                 const std::optional<std::string>& agent = std::nullopt);

// Makes what a client needs: --insecure (logged as a warning), or the authorities of the server's
// certificate. The client's own certificate and its token are optional: a server decides. The files
// are read again as above, as long as the credentials or channels of them live. Errors are as
// above.
absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> MakeChannelCredentials(
    const SecurityOptions& options);

// Makes what decides about callers by tokens alone, for a server of another kind (the viewer's),
// and reads `token_key_file` and `revoked_file` again as long as it lives. Errors are as above.
absl::StatusOr<std::shared_ptr<const AccessControl>> MakeTokenAccess(
    const SecurityOptions& options);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_SECURITY_OPTIONS_H_
