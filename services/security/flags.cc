#include "services/security/flags.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "services/command_line/help_formatter.h"
#include "services/command_line/values.h"

namespace corbslam::services {
namespace {

void AddSwitch(CLI::App& app, const std::string& flag, bool& value, const std::string& on,
               const std::string& off, const std::string& what) {
  app.add_option(flag, value, what)
      ->transform(Choice({{on, 1}, {off, 0}}))
      ->type_name(on + "|" + off)
      ->default_str(on);
}

// Reads "12h"; CLI11 says which flag has what else.
void AddDuration(CLI::App& app, const std::string& flag, absl::Duration& value,
                 const std::string& what) {
  app.add_option_function<std::string>(
         flag,
         [flag, &value](const std::string& text) {
           const bool is_duration = absl::ParseDuration(text, &value);
           if (is_duration && value >= absl::Seconds(1) && value < absl::InfiniteDuration()) return;
           throw CLI::ValidationError(
               flag, absl::StrCat("is \"", text, "\", must be at least 1s, as 90m or 720h"));
         },
         what)
      ->type_name("DURATION")
      ->group(kRareGroup);
}

}  // namespace

void AddTlsFlags(CLI::App& app, SecurityOptions& options) {
  app.add_flag("--insecure", options.insecure, "Without TLS: whoever reaches it may do everything");
  app.add_option("--tls-cert", options.certificate_file, "PEM file of this program's certificate");
  app.add_option("--tls-key", options.key_file, "PEM file of its private key");
  app.add_option("--tls-ca", options.ca_file,
                 "PEM file of the authorities whose certificates others must show");
}

void AddServerFlags(CLI::App& app, SecurityOptions& options) {
  app.add_option("--token-key", options.token_key_file,
                 "PEM file of Ed25519 public keys whose tokens are taken");
  AddTokenFlags(app, options);
  app.add_option("--audit-log", options.audit_file,
                 "File of who did what, and what was refused; - for the log; without: none")
      ->group(kRareGroup);
  app.add_option("--audit-log-bytes", options.audit_bytes,
                 "Bytes of it, as 64MiB, beyond which it becomes FILE.1 and a new one begins")
      ->transform(BytesWithin({.least = uint64_t{64} << 10, .most = uint64_t{1} << 40}))
      ->type_name(kBytesType)
      ->capture_default_str()
      ->group(kRareGroup);
  AddSwitch(app, "--reflection", options.reflection, "on", "off",
            "Whether callers may ask which methods there are");
  AddSwitch(app, "--health", options.health_is_open, "open", "closed",
            "Whether callers without an identity may ask how it is");
}

void AddTokenFlags(CLI::App& app, SecurityOptions& options) {
  app.add_option("--revoked-tokens", options.revoked_file,
                 "File of tokens' ids and identities that are refused, one a line")
      ->group(kRareGroup);
  app.add_option("--token-audience", options.audience,
                 "This server's name; tokens that are for another one are refused")
      ->group(kRareGroup);
  AddDuration(app, "--max-token-lifetime", options.max_token_lifetime,
              "Tokens that are good for longer are refused, as 720h; without: none");
}

void AddClientFlags(CLI::App& app, SecurityOptions& options) {
  app.add_option("--token-file", options.token_file, "File of the token to show to the server");
}

}  // namespace corbslam::services
