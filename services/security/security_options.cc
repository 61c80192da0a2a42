#include "services/security/security_options.h"

#include <glog/logging.h>
#include <grpcpp/security/server_credentials.h>

#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "services/convert/status.h"
#include "services/security/pem_files.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

bool NamesFiles(const SecurityOptions& options) {
  return !options.certificate_file.empty() || !options.key_file.empty() ||
         !options.ca_file.empty() || !options.token_key_file.empty() || !options.token_file.empty();
}

absl::Status CheckInsecure(const SecurityOptions& options) {
  if (!NamesFiles(options)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "--insecure excludes --tls-cert, --tls-key, --tls-ca, --token-key and --token-file");
}

absl::Status CheckServerFlags(const SecurityOptions& options) {
  if (options.certificate_file.empty() || options.key_file.empty()) {
    return absl::InvalidArgumentError(
        "a server needs --tls-cert and --tls-key (docs/security.md; deploy/"
        "make_test_certificates.sh makes some), or --insecure to serve everybody without TLS");
  }
  if (options.ca_file.empty() && options.token_key_file.empty()) {
    return absl::InvalidArgumentError(
        "a server needs to know who calls: --tls-ca, whose certificates callers then show, or "
        "--token-key, or both (docs/security.md)");
  }
  return absl::OkStatus();
}

absl::Status CheckClientFlags(const SecurityOptions& options) {
  if (options.ca_file.empty()) {
    return absl::InvalidArgumentError(
        "a client needs --tls-ca, whose certificate the server must show, and --tls-cert with "
        "--tls-key or --token-file to say who it is (docs/security.md), or --insecure to connect "
        "without TLS");
  }
  if (options.certificate_file.empty() != options.key_file.empty()) {
    return absl::InvalidArgumentError("--tls-cert and --tls-key go together");
  }
  return absl::OkStatus();
}

// Returns how much of a caller's certificate the handshake asks for.
grpc_ssl_client_certificate_request_type CertificateRequest(const SecurityOptions& options) {
  if (options.ca_file.empty()) return GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE;
  const bool strangers_may_connect = options.health_is_open || !options.token_key_file.empty();
  return strangers_may_connect ? GRPC_SSL_REQUEST_CLIENT_CERTIFICATE_AND_VERIFY
                               : GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY;
}

absl::StatusOr<std::shared_ptr<const AccessControl>> MakeAccessControl(
    const SecurityOptions& options, const std::optional<std::string>& mission,
    const std::optional<std::string>& agent) {
  AccessControlOptions access;
  access.health_is_open = options.health_is_open;
  access.mission = mission;
  access.agent = agent;
  if (!options.token_key_file.empty()) {
    ASSIGN_OR_RETURN(const std::string pem,
                     ReadSecurityFile("--token-key", options.token_key_file));
    absl::StatusOr<TokenVerifier> verifier = TokenVerifier::FromPem(pem);
    if (!verifier.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("--token-key ", options.token_key_file, ": ", verifier.status().message()));
    }
    access.tokens = *std::move(verifier);
  }
  return std::make_shared<const AccessControl>(access);
}

absl::StatusOr<std::string> ReadToken(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string text, ReadSecurityFile("--token-file", path));
  return std::string(absl::StripAsciiWhitespace(text));
}

// Adds the token of a file to every call.
class TokenFile : public grpc::MetadataCredentialsPlugin {
 public:
  explicit TokenFile(std::string path) : path_(std::move(path)) {}

  const char* GetType() const override { return "token file"; }
  // The file is small, so the thread that makes the call reads it: then nothing of a call goes on
  // elsewhere when its channel is gone.
  bool IsBlocking() const override { return false; }
  grpc::Status GetMetadata(grpc::string_ref, grpc::string_ref, const grpc::AuthContext&,
                           std::multimap<grpc::string, grpc::string>* metadata) override {
    const absl::StatusOr<std::string> token = ReadToken(path_);
    // The file may just be being replaced: the call may be tried again.
    if (!token.ok()) return ToGrpcStatus(absl::UnavailableError(token.status().message()));
    metadata->emplace("authorization", absl::StrCat("Bearer ", *token));
    return grpc::Status::OK;
  }

 private:
  const std::string path_;
};

}  // namespace

absl::StatusOr<ServerSecurity> MakeServerSecurity(const SecurityOptions& options,
                                                  const std::optional<std::string>& mission,
                                                  const std::optional<std::string>& agent) {
  ServerSecurity security;
  security.server.reflection = options.reflection;
  if (options.insecure) {
    RETURN_IF_ERROR(CheckInsecure(options));
    LOG(WARNING) << "--insecure: serving without TLS; everybody who reaches this address may read, "
                    "write and delete";
    // Nobody has an identity that could be asked for.
    security.server.health = options.health_is_open;
    return security;
  }
  RETURN_IF_ERROR(CheckServerFlags(options));
  grpc::SslServerCredentialsOptions tls(CertificateRequest(options));
  ASSIGN_OR_RETURN(KeyPair pair, ReadKeyPair(options.certificate_file, options.key_file));
  tls.pem_key_cert_pairs.push_back({std::move(pair.key_pem), std::move(pair.certificate_pem)});
  if (!options.ca_file.empty()) {
    ASSIGN_OR_RETURN(tls.pem_root_certs, ReadAuthorities(options.ca_file));
  }
  ASSIGN_OR_RETURN(security.access, MakeAccessControl(options, mission, agent));
  security.server.credentials = grpc::SslServerCredentials(tls);
  security.server.credentials->SetAuthMetadataProcessor(MakeCallGate(security.access));
  return security;
}

absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> MakeChannelCredentials(
    const SecurityOptions& options) {
  if (options.insecure) {
    RETURN_IF_ERROR(CheckInsecure(options));
    LOG(WARNING) << "--insecure: connecting without TLS; anybody on the way can read and change "
                    "what is sent";
    return grpc::InsecureChannelCredentials();
  }
  RETURN_IF_ERROR(CheckClientFlags(options));
  grpc::SslCredentialsOptions tls;
  ASSIGN_OR_RETURN(tls.pem_root_certs, ReadAuthorities(options.ca_file));
  if (!options.certificate_file.empty()) {
    ASSIGN_OR_RETURN(KeyPair pair, ReadKeyPair(options.certificate_file, options.key_file));
    tls.pem_cert_chain = std::move(pair.certificate_pem);
    tls.pem_private_key = std::move(pair.key_pem);
  }
  const std::shared_ptr<grpc::ChannelCredentials> channel = grpc::SslCredentials(tls);
  if (options.token_file.empty()) return channel;
  RETURN_IF_ERROR(ReadToken(options.token_file).status());
  return grpc::CompositeChannelCredentials(
      channel,
      grpc::MetadataCredentialsFromPlugin(std::make_unique<TokenFile>(options.token_file)));
}

}  // namespace corbslam::services
