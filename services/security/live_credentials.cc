#include "services/security/live_credentials.h"

#include <grpcpp/security/tls_certificate_verifier.h>
#include <grpcpp/security/tls_credentials_options.h>

#include <functional>
#include <utility>

namespace corbslam::services {
namespace {

using grpc::experimental::ExternalCertificateVerifier;
using grpc::experimental::HostNameCertificateVerifier;
using grpc::experimental::TlsCustomVerificationCheckRequest;

// Checks that a server's certificate is for the host that was called. gRPC destroys it with the
// credentials, which makes it the place for what they need: nothing else of ours lives so long.
class HostVerifier : public ExternalCertificateVerifier {
 public:
  explicit HostVerifier(std::shared_ptr<const void> kept) : kept_(std::move(kept)) {}

  bool Verify(TlsCustomVerificationCheckRequest* request,
              std::function<void(grpc::Status)> callback, grpc::Status* sync_status) override {
    return host_name_.Verify(request, std::move(callback), sync_status);
  }
  void Cancel(TlsCustomVerificationCheckRequest* request) override { host_name_.Cancel(request); }

 private:
  const std::shared_ptr<const void> kept_;
  HostNameCertificateVerifier host_name_;
};

// Checks nothing more of a caller's certificate than the handshake has: callers have no host name.
class CallerVerifier : public ExternalCertificateVerifier {
 public:
  explicit CallerVerifier(std::shared_ptr<const void> kept) : kept_(std::move(kept)) {}

  bool Verify(TlsCustomVerificationCheckRequest*, std::function<void(grpc::Status)>,
              grpc::Status* sync_status) override {
    *sync_status = grpc::Status::OK;
    return true;
  }
  void Cancel(TlsCustomVerificationCheckRequest*) override {}

 private:
  const std::shared_ptr<const void> kept_;
};

void Watch(const KeyMaterial& material, grpc::experimental::TlsCredentialsOptions& options) {
  if (material.has_pair()) options.watch_identity_key_cert_pairs();
  if (material.has_authorities()) options.watch_root_certs();
}

}  // namespace

std::shared_ptr<grpc::ServerCredentials> MakeLiveServerCredentials(
    const KeyMaterial& material, grpc_ssl_client_certificate_request_type request,
    std::shared_ptr<const void> kept) {
  grpc::experimental::TlsServerCredentialsOptions options(material.MakeProvider());
  Watch(material, options);
  options.set_cert_request_type(request);
  options.set_certificate_verifier(
      ExternalCertificateVerifier::Create<CallerVerifier>(std::move(kept)));
  return grpc::experimental::TlsServerCredentials(options);
}

std::shared_ptr<grpc::ChannelCredentials> MakeLiveChannelCredentials(
    const KeyMaterial& material, std::shared_ptr<const void> kept) {
  grpc::experimental::TlsChannelCredentialsOptions options;
  options.set_certificate_provider(material.MakeProvider());
  Watch(material, options);
  options.set_certificate_verifier(
      ExternalCertificateVerifier::Create<HostVerifier>(std::move(kept)));
  return grpc::experimental::TlsCredentials(options);
}

}  // namespace corbslam::services
