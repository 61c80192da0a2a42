// TLS and identities of our programs, from the files that their flags name.
#ifndef CORBSLAM_SERVICES_SECURITY_SECURITY_OPTIONS_H_
#define CORBSLAM_SERVICES_SECURITY_SECURITY_OPTIONS_H_

#include <grpcpp/security/credentials.h>

#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "services/security/access_control.h"
#include "services/server/server.h"

namespace corbslam {

struct SecurityOptions {
  // Neither encryption nor identities: everybody may do everything.
  bool insecure = false;
  // This program's certificate (then those between it and the authority) and its key, as PEM.
  std::string certificate_file;
  std::string key_file;
  // Authorities whose certificates are trusted, as PEM.
  std::string ca_file;
  // Of servers: public keys of tokens that are taken, as PEM.
  std::string token_key_file;
  // Of clients: the token to show. Read again for each call, so that it can be replaced.
  std::string token_file;
  // Of servers.
  bool reflection = true;
  bool health_is_open = true;
};

// What --insecure means.
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

// What a server needs: --insecure (logged as a warning), or a certificate, its key, and a way to
// tell who calls: authorities, whose certificates are then demanded, or token keys. A caller
// without a certificate gets as far as a call only where token keys are given or health is open.
// `mission`: see AccessControlOptions. INVALID_ARGUMENT says which flag is missing, what is wrong
// with which file, or which flags exclude each other.
absl::StatusOr<ServerSecurity> MakeServerSecurity(
    const SecurityOptions& options, const std::optional<std::string>& mission = std::nullopt);

// What a client needs: --insecure (logged as a warning), or the authorities of the server's
// certificate. Its own certificate and its token are optional: a server decides. Errors as above.
absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> MakeChannelCredentials(
    const SecurityOptions& options);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SECURITY_SECURITY_OPTIONS_H_
