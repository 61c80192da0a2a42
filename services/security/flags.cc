#include "services/security/flags.h"

#include <map>
#include <string>

namespace corbslam::services {
namespace {

void AddSwitch(CLI::App& app, const std::string& flag, bool& value, const std::string& on,
               const std::string& off, const std::string& what) {
  app.add_option(flag, value, what)
      ->transform(CLI::CheckedTransformer(std::map<std::string, bool>{{on, true}, {off, false}}))
      ->type_name(on + "|" + off)
      ->default_str(on);
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
  AddSwitch(app, "--reflection", options.reflection, "on", "off",
            "Whether callers may ask which methods there are");
  AddSwitch(app, "--health", options.health_is_open, "open", "closed",
            "Whether callers without an identity may ask how it is");
}

void AddClientFlags(CLI::App& app, SecurityOptions& options) {
  app.add_option("--token-file", options.token_file, "File of the token to show to the server");
}

}  // namespace corbslam::services
