#include "services/viewer/web_certificate.h"

#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "services/security/pem_files.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Owns the key pair and what replaces it.
struct WatchedTls {
  explicit WatchedTls(absl::Duration interval) : watch(interval) {}

  std::unique_ptr<WebTls> tls;
  // Declared last, so that it ends first.
  CredentialWatch watch;
};

// Returns the key, then the certificates.
absl::StatusOr<std::string> ReadPair(const std::string& certificate_path,
                                     const std::string& key_path) {
  ASSIGN_OR_RETURN(const KeyPair pair,
                   ReadKeyPair(certificate_path, key_path, "--web-cert", "--web-key"));
  return absl::StrCat(pair.key_pem, "\n", pair.certificate_pem);
}

// `pem` has both, of which readers take what they look for.
absl::Status Take(const std::string& pem, WatchedTls& watched) {
  if (watched.tls != nullptr) return watched.tls->Replace(pem, pem);
  ASSIGN_OR_RETURN(watched.tls, WebTls::Make(pem, pem));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::shared_ptr<const WebTls>> WatchWebCertificate(
    const std::string& certificate_path, const std::string& key_path, absl::Duration interval) {
  const auto watched = std::make_shared<WatchedTls>(interval);
  const auto read = [certificate_path, key_path] { return ReadPair(certificate_path, key_path); };
  // The watch ends before what it writes to.
  const auto take = [certificate_path, held = watched.get()](const std::string& pem) {
    const absl::Status status = Take(pem, *held);
    if (status.ok()) return status;
    return absl::InvalidArgumentError(
        absl::StrCat("--web-cert ", certificate_path, ": ", status.message()));
  };
  RETURN_IF_ERROR(watched->watch.Add({Credential::kWebCertificate, read, take}));
  watched->watch.Start();
  return std::shared_ptr<const WebTls>(watched, watched->tls.get());
}

}  // namespace corbslam::services
