#include "services/client/reachability/tls_probe.h"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>

#include <csignal>
#include <memory>

#include "absl/cleanup/cleanup.h"
#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "services/client/reachability/tcp_probe.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

std::string ToPem(STACK_OF(X509) * chain) {
  const std::unique_ptr<BIO, decltype(&BIO_free)> bio(BIO_new(BIO_s_mem()), BIO_free);
  for (int i = 0; i < sk_X509_num(chain); ++i)
    PEM_write_bio_X509(bio.get(), sk_X509_value(chain, i));
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &data);
  return {data, static_cast<size_t>(size)};
}

}  // namespace

absl::StatusOr<std::string> FetchCertificates(const HostPort& address, absl::Duration timeout) {
  ASSIGN_OR_RETURN(const Connection connection, Connect(address, timeout));
  connection.MakeBlocking(timeout);
  // OpenSSL writes to connections that the other side has closed, which raises SIGPIPE.
  const auto before = std::signal(SIGPIPE, SIG_IGN);
  const absl::Cleanup restore = [&] { std::signal(SIGPIPE, before); };
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context(SSL_CTX_new(TLS_client_method()),
                                                                  SSL_CTX_free);
  SSL_CTX_set_verify(context.get(), SSL_VERIFY_NONE, nullptr);
  // gRPC speaks HTTP/2, which ALPN calls "h2".
  constexpr unsigned char kHttp2[] = {2, 'h', '2'};
  SSL_CTX_set_alpn_protos(context.get(), kHttp2, sizeof(kHttp2));
  const std::unique_ptr<SSL, decltype(&SSL_free)> session(SSL_new(context.get()), SSL_free);
  SSL_set_fd(session.get(), connection.socket());
  SSL_set_tlsext_host_name(session.get(), address.host.c_str());
  const bool connected = SSL_connect(session.get()) == 1;
  ERR_clear_error();
  STACK_OF(X509)* chain = SSL_get_peer_cert_chain(session.get());
  // A server that wants a certificate of its caller may have shown its own already.
  if (chain == nullptr || sk_X509_num(chain) == 0) {
    return absl::UnavailableError(
        absl::StrCat(ToString(address), connected ? ": shows no certificate" : ": speaks no TLS"));
  }
  return ToPem(chain);
}

}  // namespace corbslam::services
