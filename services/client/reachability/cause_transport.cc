// Finds out what a server speaks that is reached: TLS or none, HTTP/2 or something else, and with
// which certificate.
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/client/reachability/cause.h"
#include "services/client/reachability/protocol_probe.h"
#include "services/client/reachability/proxy.h"
#include "services/client/reachability/tls_probe.h"
#include "services/runtime/address.h"
#include "services/security/certificate_checks.h"
#include "services/security/pem_files.h"

namespace corbslam::services {
namespace {

constexpr char kOtherPort[] =
    "is it the port of another program, or of metrics? Give the one that the server says it is "
    "\"listening on\"";

// Returns the cause for a server that speaks neither HTTP/2 nor TLS.
Cause CauseOfProtocol(Protocol protocol) {
  switch (protocol) {
    case Protocol::kHttp1:
      return {"a web server does (HTTP/1), and gRPC needs HTTP/2", kOtherPort};
    case Protocol::kClosed:
      return {"whoever listens there hangs up at once", kOtherPort};
    case Protocol::kSilent:
      return {
          "it takes connections and says nothing: it hangs (its process is stopped, or waits for "
          "its disk), or the network holds back what is sent",
          "look at its process, its log and its disk; if it never answered there, is it the "
          "port of another program, or of metrics?",
          /*is_certain=*/false};
    default:
      return {"another kind of program listens there", kOtherPort};
  }
}

std::optional<Cause> FindCauseWithoutTls(const HostPort& address, absl::Duration patience) {
  const absl::StatusOr<Protocol> protocol = ProbeProtocol(address, patience);
  if (!protocol.ok()) return Cause{std::string(protocol.status().message()), ""};
  if (*protocol == Protocol::kHttp2) return std::nullopt;
  const bool may_be_tls = *protocol != Protocol::kHttp1 && *protocol != Protocol::kOther;
  if (may_be_tls && FetchCertificates(address, patience).ok()) {
    return Cause{"the server there speaks TLS, and --insecure says that this side does not",
                 "leave --insecure out, and give --tls-ca (docs/security.md)"};
  }
  return CauseOfProtocol(*protocol);
}

// Returns nullopt if the certificate is good for this client.
std::optional<Cause> FindCauseInCertificate(const ServerTarget& target, const HostPort& address,
                                            const std::string& pem) {
  Findings findings = {CheckExpiry("", pem, absl::Now()), CheckHost("", pem, address.host)};
  const absl::StatusOr<std::string> authorities = ReadAuthorities(target.security.ca_file);
  if (authorities.ok()) findings.push_back(CheckChain("", pem, *authorities));
  for (const Finding& finding : findings) {
    if (finding.level != Level::kFail) continue;
    return Cause{"the certificate of the server there " + finding.text, finding.advice};
  }
  return std::nullopt;
}

// Returns nullopt if the server takes this side's certificate, or does without one.
std::optional<Cause> FindCauseInOwnCertificate(const ServerTarget& target, const HostPort& address,
                                               absl::Duration patience) {
  const SecurityOptions& own = target.security;
  KeyPair pair;
  if (!own.certificate_file.empty()) {
    const absl::StatusOr<KeyPair> read = ReadKeyPair(own.certificate_file, own.key_file);
    if (!read.ok()) return Cause{std::string(read.status().message()), ""};
    pair = *read;
  }
  const std::optional<std::string> said =
      ProbeOwnCertificate(address, pair.certificate_pem, pair.key_pem, patience);
  if (!said.has_value()) return std::nullopt;
  const std::string quoted = said->empty() ? "" : absl::StrCat(" (\"", *said, "\")");
  if (own.certificate_file.empty()) {
    return Cause{absl::StrCat("the server there hangs up on callers without a certificate", quoted),
                 "give --tls-cert and --tls-key (docs/security.md)"};
  }
  const Finding expiry = CheckExpiry("", pair.certificate_pem, absl::Now());
  if (expiry.level == Level::kFail) {
    return Cause{absl::StrCat("the server there refuses this side's certificate, --tls-cert ",
                              own.certificate_file, quoted, ", which ", expiry.text),
                 expiry.advice};
  }
  return Cause{absl::StrCat("the server there refuses this side's certificate, --tls-cert ",
                            own.certificate_file, quoted),
               "it must be issued by an authority of the server's --tls-ca (docs/security.md)"};
}

std::optional<Cause> FindCauseWithTls(const ServerTarget& target, const HostPort& address,
                                      absl::Duration patience) {
  const absl::StatusOr<std::string> pem = FetchCertificates(address, patience);
  if (pem.ok()) {
    std::optional<Cause> cause = FindCauseInCertificate(target, address, *pem);
    return cause.has_value() ? cause : FindCauseInOwnCertificate(target, address, patience);
  }
  const absl::StatusOr<Protocol> protocol = ProbeProtocol(address, patience);
  if (!protocol.ok()) return Cause{std::string(protocol.status().message()), ""};
  if (*protocol != Protocol::kHttp2) return CauseOfProtocol(*protocol);
  return Cause{"the server there speaks no TLS, and this side does",
               "start it with a certificate (docs/security.md), or say --insecure here, too"};
}

}  // namespace

std::optional<Cause> FindCauseOfTransport(const ServerTarget& target, absl::Duration patience) {
  const absl::StatusOr<HostPort> address = ParseServerAddress(target.address);
  // These probes would not go through a proxy.
  if (!address.ok() || FindProxy(address->host).has_value()) return std::nullopt;
  return target.security.insecure ? FindCauseWithoutTls(*address, patience)
                                  : FindCauseWithTls(target, *address, patience);
}

}  // namespace corbslam::services
