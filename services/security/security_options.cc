#include "services/security/security_options.h"

#include <glog/logging.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "services/convert/status.h"
#include "services/security/credential_watch.h"
#include "services/security/key_material.h"
#include "services/security/live_credentials.h"
#include "services/security/pem_files.h"
#include "services/security/placeholder_pair.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

bool NamesFiles(const SecurityOptions& options) {
  return !options.certificate_file.empty() || !options.key_file.empty() ||
         !options.ca_file.empty() || !options.token_key_file.empty() ||
         !options.token_file.empty() || !options.revoked_file.empty();
}

absl::Status CheckInsecure(const SecurityOptions& options) {
  if (!NamesFiles(options)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "--insecure excludes --tls-cert, --tls-key, --tls-ca, --token-key, --revoked-tokens and "
      "--token-file");
}

absl::Status CheckTokenFlags(const SecurityOptions& options) {
  if (!options.audience.empty()) {
    RETURN_IF_ERROR(CheckTokenWord("--token-audience", options.audience));
  }
  const bool limits_tokens =
      !options.audience.empty() || options.max_token_lifetime < absl::InfiniteDuration();
  if (!limits_tokens || !options.token_key_file.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "--token-audience and --max-token-lifetime are about tokens: they need --token-key");
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
  return CheckTokenFlags(options);
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

absl::StatusOr<TokenVerifier> ParseTokenKeys(const std::string& path, const std::string& pem) {
  absl::StatusOr<TokenVerifier> verifier = TokenVerifier::FromPem(pem);
  if (verifier.ok()) return verifier;
  return absl::InvalidArgumentError(
      absl::StrCat("--token-key ", path, ": ", verifier.status().message()));
}

absl::StatusOr<RevokedList> ParseRevoked(const std::string& path, const std::string& text) {
  absl::StatusOr<RevokedList> revoked = RevokedList::Parse(text);
  if (revoked.ok()) return revoked;
  return absl::InvalidArgumentError(
      absl::StrCat("--revoked-tokens ", path, ": ", revoked.status().message()));
}

// Has the watch look after a source, which may not be good yet where the options say so.
absl::Status WatchSource(const SecurityOptions& options, CredentialWatch::Source source,
                         CredentialWatch& watch) {
  if (!options.files_may_come) return watch.Add(std::move(source));
  watch.AddOrWait(std::move(source));
  return absl::OkStatus();
}

// Owns what is replaced while a program runs, and what replaces it. gRPC's credentials own it.
struct Living {
  KeyMaterial material;
  std::shared_ptr<AccessControl> access;
  // Declared last, so that it ends first.
  CredentialWatch watch;
};

absl::Status WatchPair(const SecurityOptions& options, Living& living) {
  if (options.certificate_file.empty()) return absl::OkStatus();
  const auto read = [options]() -> absl::StatusOr<std::string> {
    ASSIGN_OR_RETURN(const KeyPair pair, ReadKeyPair(options.certificate_file, options.key_file));
    return absl::StrCat(pair.key_pem, "\n", pair.certificate_pem);
  };
  // What gRPC looks at is there from the beginning.
  if (options.files_may_come) {
    ASSIGN_OR_RETURN(const KeyPair nobodys, MakePlaceholderPair());
    RETURN_IF_ERROR(
        living.material.SetPair(absl::StrCat(nobodys.key_pem, "\n", nobodys.certificate_pem)));
  }
  return WatchSource(options,
                     {Credential::kCertificate, read,
                      [&living](const std::string& pem) { return living.material.SetPair(pem); }},
                     living.watch);
}

absl::Status WatchAuthorities(const SecurityOptions& options, Living& living) {
  if (options.ca_file.empty()) return absl::OkStatus();
  if (options.files_may_come) {
    ASSIGN_OR_RETURN(const KeyPair nobodys, MakePlaceholderPair());
    RETURN_IF_ERROR(living.material.SetAuthorities(nobodys.certificate_pem));
  }
  return WatchSource(
      options,
      {Credential::kAuthorities, [options] { return ReadAuthorities(options.ca_file); },
       [&living](const std::string& pem) { return living.material.SetAuthorities(pem); }},
      living.watch);
}

absl::Status WatchTokenKeys(const SecurityOptions& options, Living& living) {
  const std::string& path = options.token_key_file;
  if (path.empty()) return absl::OkStatus();
  const auto read = [path]() -> absl::StatusOr<std::string> {
    ASSIGN_OR_RETURN(std::string pem, ReadSecurityFile("--token-key", path));
    RETURN_IF_ERROR(ParseTokenKeys(path, pem).status());
    return pem;
  };
  return WatchSource(options,
                     {Credential::kTokenKeys, read,
                      [path, &living](const std::string& pem) -> absl::Status {
                        ASSIGN_OR_RETURN(TokenVerifier verifier, ParseTokenKeys(path, pem));
                        living.access->SetTokens(std::move(verifier));
                        return absl::OkStatus();
                      }},
                     living.watch);
}

absl::Status WatchRevoked(const SecurityOptions& options, Living& living) {
  const std::string& path = options.revoked_file;
  if (path.empty()) return absl::OkStatus();
  const auto read = [path]() -> absl::StatusOr<std::string> {
    ASSIGN_OR_RETURN(std::string text, ReadListFile("--revoked-tokens", path));
    RETURN_IF_ERROR(ParseRevoked(path, text).status());
    return text;
  };
  return living.watch.Add(
      {Credential::kRevokedTokens, read, [path, &living](const std::string& text) -> absl::Status {
         ASSIGN_OR_RETURN(RevokedList revoked, ParseRevoked(path, text));
         living.access->SetRevoked(std::move(revoked));
         return absl::OkStatus();
       }});
}

absl::StatusOr<std::shared_ptr<Living>> MakeLivingServer(const SecurityOptions& options,
                                                         const std::optional<std::string>& mission,
                                                         const std::optional<std::string>& agent) {
  AccessControlOptions access;
  access.health_is_open = options.health_is_open;
  access.audience = options.audience;
  access.max_token_lifetime = options.max_token_lifetime;
  access.mission = mission;
  access.agent = agent;
  auto living = std::make_shared<Living>();
  living->access = std::make_shared<AccessControl>(access);
  RETURN_IF_ERROR(WatchPair(options, *living));
  RETURN_IF_ERROR(WatchAuthorities(options, *living));
  RETURN_IF_ERROR(WatchTokenKeys(options, *living));
  RETURN_IF_ERROR(WatchRevoked(options, *living));
  return living;
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

// Makes what hears of calls, and the gate that tells it whom it turned away.
absl::Status Audit(const SecurityOptions& options, ServerSecurity& security) {
  ASSIGN_OR_RETURN(const std::shared_ptr<AuditLog> log,
                   AuditLog::Open({.file = options.audit_file, .max_bytes = options.audit_bytes},
                                  security.access));
  security.server.auditor = log;
  if (security.access == nullptr) return absl::OkStatus();
  security.server.credentials->SetAuthMetadataProcessor(MakeCallGate(
      security.access, [log](absl::string_view method, const Evidence& evidence,
                             absl::string_view user_agent, const absl::Status& status) {
        log->OnTurnedAway(method, evidence, user_agent, status);
      }));
  return absl::OkStatus();
}

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
    RETURN_IF_ERROR(Audit(options, security));
    return security;
  }
  RETURN_IF_ERROR(CheckServerFlags(options));
  ASSIGN_OR_RETURN(const std::shared_ptr<Living> living, MakeLivingServer(options, mission, agent));
  security.access = living->access;
  security.server.credentials =
      MakeLiveServerCredentials(living->material, CertificateRequest(options), living);
  living->watch.Start();
  RETURN_IF_ERROR(Audit(options, security));
  return security;
}

absl::Status CheckServerSecurity(const SecurityOptions& options,
                                 const std::optional<std::string>& mission,
                                 const std::optional<std::string>& agent) {
  SecurityOptions unlogged = options;
  unlogged.audit_file.clear();
  RETURN_IF_ERROR(MakeServerSecurity(unlogged, mission, agent).status());
  if (options.audit_file.empty() || options.audit_file == "-") return absl::OkStatus();
  std::error_code error;
  const std::filesystem::path folder =
      std::filesystem::absolute(options.audit_file, error).parent_path();
  if (std::filesystem::is_directory(folder, error)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("--audit-log ", options.audit_file, ": there is no folder ", folder.string()));
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
  const auto living = std::make_shared<Living>();
  RETURN_IF_ERROR(WatchAuthorities(options, *living));
  RETURN_IF_ERROR(WatchPair(options, *living));
  const std::shared_ptr<grpc::ChannelCredentials> channel =
      MakeLiveChannelCredentials(living->material, living);
  living->watch.Start();
  if (options.token_file.empty()) return channel;
  const absl::Status token = ReadToken(options.token_file).status();
  if (!options.files_may_come) RETURN_IF_ERROR(token);
  LOG_IF(ERROR, !token.ok()) << "credentials, token: " << token.message()
                             << "; the file is read again for each call";
  return grpc::CompositeChannelCredentials(
      channel,
      grpc::MetadataCredentialsFromPlugin(std::make_unique<TokenFile>(options.token_file)));
}

absl::StatusOr<std::shared_ptr<const AccessControl>> MakeTokenAccess(
    const SecurityOptions& options) {
  SecurityOptions tokens;
  tokens.token_key_file = options.token_key_file;
  tokens.revoked_file = options.revoked_file;
  tokens.audience = options.audience;
  tokens.max_token_lifetime = options.max_token_lifetime;
  RETURN_IF_ERROR(CheckTokenFlags(tokens));
  ASSIGN_OR_RETURN(const std::shared_ptr<Living> living,
                   MakeLivingServer(tokens, std::nullopt, std::nullopt));
  living->watch.Start();
  return std::shared_ptr<const AccessControl>(living, living->access.get());
}

}  // namespace corbslam::services
