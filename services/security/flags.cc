#include "services/security/flags.h"

#include "services/command_line/setting.h"

namespace corbslam::services {
void AddTlsFlags(CLI::App& app, SecurityOptions& options) {
  AddSettings(
      app,
      {
          {"--insecure", &options.insecure, "Without TLS: whoever reaches it may do everything"},
          {"--tls-cert", &options.certificate_file, "PEM file of this program's certificate"},
          {"--tls-key", &options.key_file, "PEM file of its private key"},
          {"--tls-ca", &options.ca_file,
           "PEM file of the authorities whose certificates others must show"},
      });
}

void AddServerFlags(CLI::App& app, SecurityOptions& options) {
  AddSettings(app, {{"--token-key", &options.token_key_file,
                     "PEM file of Ed25519 public keys whose tokens are taken"}});
  AddTokenFlags(app, options);
  AddSettings(
      app, {
               {"--audit-log", &options.audit_file,
                "File of who did what, and what was refused; - for the log; without: none", kRare},
               {"--audit-log-bytes",
                &options.audit_bytes,
                "Bytes of it, as 64MiB, beyond which it becomes FILE.1 and a new one begins",
                {.in = Bytes(uint64_t{64} << 10, uint64_t{1} << 40), .rare = true}},
               {"--reflection", OneOf("on", "off", &options.reflection),
                "Whether callers may ask which methods there are"},
               {"--health", OneOf("open", "closed", &options.health_is_open),
                "Whether callers without an identity may ask how it is"},
           });
}

void AddTokenFlags(CLI::App& app, SecurityOptions& options) {
  AddSettings(app,
              {
                  {"--revoked-tokens", &options.revoked_file,
                   "File of tokens' ids and identities that are refused, one a line", kRare},
                  {"--token-audience", &options.audience,
                   "This server's name; tokens that are for another one are refused", kRare},
                  {"--max-token-lifetime", &options.max_token_lifetime,
                   "Tokens that are good for longer are refused, as 720h; without: none", kRare},
              });
}

void AddClientFlags(CLI::App& app, SecurityOptions& options) {
  AddSettings(app,
              {{"--token-file", &options.token_file, "File of the token to show to the server"}});
}

}  // namespace corbslam::services
