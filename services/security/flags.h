// Adds the flags of SecurityOptions, which are the same in every program.
#ifndef CORBSLAM_SERVICES_SECURITY_FLAGS_H_
#define CORBSLAM_SERVICES_SECURITY_FLAGS_H_

#include <CLI/CLI.hpp>

#include "services/security/security_options.h"

namespace corbslam::services {

// Adds --insecure, --tls-cert, --tls-key, --tls-ca. The options must outlive the parsing.
void AddTlsFlags(CLI::App& app, SecurityOptions& options);
// Adds --token-key, --reflection, --health, the audit log's, and those below.
void AddServerFlags(CLI::App& app, SecurityOptions& options);
// Adds --revoked-tokens, --token-audience and --max-token-lifetime, which --help-all shows.
void AddTokenFlags(CLI::App& app, SecurityOptions& options);
// Adds --token-file.
void AddClientFlags(CLI::App& app, SecurityOptions& options);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_FLAGS_H_
