#include "services/client/reachability/tls_probe.h"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>

#include <cerrno>
#include <csignal>
#include <memory>

#include "absl/cleanup/cleanup.h"
#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
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

using Context = std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)>;
using Session = std::unique_ptr<SSL, decltype(&SSL_free)>;

Context MakeContext() {
  Context context(SSL_CTX_new(TLS_client_method()), SSL_CTX_free);
  SSL_CTX_set_verify(context.get(), SSL_VERIFY_NONE, nullptr);
  // gRPC speaks HTTP/2, which ALPN calls "h2".
  constexpr unsigned char kHttp2[] = {2, 'h', '2'};
  SSL_CTX_set_alpn_protos(context.get(), kHttp2, sizeof(kHttp2));
  return context;
}

Session MakeSession(const Context& context, const Connection& connection, const HostPort& address) {
  Session session(SSL_new(context.get()), SSL_free);
  SSL_set_fd(session.get(), connection.socket());
  SSL_set_tlsext_host_name(session.get(), address.host.c_str());
  return session;
}

using Bio = std::unique_ptr<BIO, decltype(&BIO_free)>;

Bio BioOf(const std::string& pem) {
  return {BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())), BIO_free};
}

// Returns false if the two are no pair.
bool UseCertificate(const std::string& certificate_pem, const std::string& key_pem,
                    const Context& context) {
  const std::unique_ptr<X509, decltype(&X509_free)> certificate(
      PEM_read_bio_X509(BioOf(certificate_pem).get(), nullptr, nullptr, nullptr), X509_free);
  const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> key(
      PEM_read_bio_PrivateKey(BioOf(key_pem).get(), nullptr, nullptr, nullptr), EVP_PKEY_free);
  return certificate != nullptr && key != nullptr &&
         SSL_CTX_use_certificate(context.get(), certificate.get()) == 1 &&
         SSL_CTX_use_PrivateKey(context.get(), key.get()) == 1;
}

// Returns what the other side said before it hung up, "unknown ca".
std::string AlertOf(unsigned long error) {
  const char* reason = error == 0 ? nullptr : ERR_reason_error_string(error);
  absl::string_view text = reason == nullptr ? "" : reason;
  for (const char* begin : {"tlsv1 alert ", "tlsv13 alert ", "sslv3 alert "}) {
    if (absl::ConsumePrefix(&text, begin)) return std::string(text);
  }
  return "";
}

}  // namespace

absl::StatusOr<std::string> FetchCertificates(const HostPort& address, absl::Duration timeout) {
  ASSIGN_OR_RETURN(const Connection connection, Connect(address, timeout));
  connection.MakeBlocking(timeout);
  // OpenSSL writes to connections that the other side has closed, which raises SIGPIPE.
  const auto before = std::signal(SIGPIPE, SIG_IGN);
  const absl::Cleanup restore = [&] { std::signal(SIGPIPE, before); };
  const Context context = MakeContext();
  const Session session = MakeSession(context, connection, address);
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

std::optional<std::string> ProbeOwnCertificate(const HostPort& address,
                                               const std::string& certificate_pem,
                                               const std::string& key_pem, absl::Duration timeout) {
  const absl::StatusOr<Connection> connection = Connect(address, timeout);
  if (!connection.ok()) return std::nullopt;
  connection->MakeBlocking(timeout);
  const auto before = std::signal(SIGPIPE, SIG_IGN);
  const absl::Cleanup restore = [&] { std::signal(SIGPIPE, before); };
  const Context context = MakeContext();
  if (!certificate_pem.empty() && !UseCertificate(certificate_pem, key_pem, context)) {
    ERR_clear_error();
    return std::nullopt;
  }
  const Session session = MakeSession(context, *connection, address);
  ERR_clear_error();
  // A server of TLS 1.3 looks at the certificate when this side is already done; one that takes it
  // sends its HTTP/2 settings at once.
  char first = 0;
  int result = SSL_connect(session.get());
  if (result == 1) result = SSL_read(session.get(), &first, 1);
  const int kind = SSL_get_error(session.get(), result);
  const std::string alert = AlertOf(ERR_peek_error());
  ERR_clear_error();
  // A blocking read that takes too long says that it wants to read.
  if (result == 1 || kind == SSL_ERROR_WANT_READ) return std::nullopt;
  const bool is_timeout = kind == SSL_ERROR_SYSCALL && (errno == EAGAIN || errno == EWOULDBLOCK);
  return is_timeout ? std::nullopt : std::optional(alert);
}

}  // namespace corbslam::services
