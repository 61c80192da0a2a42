// health asks a server of this machine whether it serves, for the health checks and probes of
// containers.
#include <grpcpp/security/tls_credentials_options.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/health_client.h"
#include "services/runtime/address.h"
#include "services/server/server.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr absl::Duration kTimeout = absl::Seconds(4);

struct Flags {
  std::string service = kReadiness;
  std::string address;
  std::string ca;
  std::string certificate;
  std::string key;
};

// Makes credentials for a server that must have a certificate of the authority, under whatever
// name: it is asked by the address that only its own host has.
std::shared_ptr<grpc::ChannelCredentials> MakeCredentials(const Flags& flags) {
  if (flags.ca.empty()) return grpc::InsecureChannelCredentials();
  namespace tls = grpc::experimental;
  std::vector<tls::IdentityKeyCertPair> identity;
  tls::TlsChannelCredentialsOptions options;
  options.set_certificate_provider(std::make_shared<tls::FileWatcherCertificateProvider>(
      flags.key, flags.certificate, flags.ca, 3600));
  options.watch_root_certs();
  if (!flags.certificate.empty()) options.watch_identity_key_cert_pairs();
  options.set_verify_server_certs(true);
  options.set_check_call_host(false);
  options.set_certificate_verifier(std::make_shared<tls::NoOpCertificateVerifier>());
  return tls::TlsCredentials(options);
}

absl::Status Ask(const Flags& flags) {
  RETURN_IF_ERROR(ParseServerAddress(flags.address).status());
  return CheckHealth(MakeChannel(flags.address, MakeCredentials(flags)), flags.service, kTimeout);
}

void AddFlags(CLI::App& app, Flags& flags) {
  app.add_option("service", flags.service, "readiness or liveness")->capture_default_str();
  app.add_option("address", flags.address, "HOST:PORT; empty: there is nothing to ask")
      ->envname("CORBSLAM_HEALTH_ADDRESS");
  app.add_option("--tls-ca", flags.ca,
                 "PEM file of the server's authority; without: no TLS. The name in the "
                 "certificate is not looked at")
      ->envname("CORBSLAM_HEALTH_CA");
  auto* certificate = app.add_option("--tls-cert", flags.certificate,
                                     "Who asks, where --health=closed wants to know")
                          ->envname("CORBSLAM_HEALTH_CERT");
  auto* key = app.add_option("--tls-key", flags.key, "Its key")->envname("CORBSLAM_HEALTH_KEY");
  certificate->needs(key);
  key->needs(certificate);
}

}  // namespace
}  // namespace corbslam::services

int main(int argc, char** argv) {
  corbslam::services::Flags flags;
  CLI::App app("Ends with 0 if the server says SERVING, else with 1 and why", "health");
  corbslam::services::AddFlags(app, flags);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // docs/exit_codes.md
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (flags.address.empty()) return 0;
  const absl::Status status = corbslam::services::Ask(flags);
  if (status.ok()) return 0;
  std::fprintf(stderr, "health: %s of %s: %s\n", flags.service.c_str(), flags.address.c_str(),
               status.ToString().c_str());
  return 1;
}
