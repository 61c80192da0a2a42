#include "services/doctor/tls_probe.h"

#include <fcntl.h>
#include <netdb.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <memory>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

absl::Status Unreachable(const std::string& address, absl::string_view why) {
  return absl::UnavailableError(absl::StrCat(address, ": ", why));
}

// 0 once connected, else errno.
int WaitUntilConnected(int socket, absl::Duration timeout) {
  pollfd entry = {socket, POLLOUT, 0};
  if (poll(&entry, 1, static_cast<int>(absl::ToInt64Milliseconds(timeout))) != 1) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof(error);
  getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

// A connected socket, or minus errno.
int ConnectOne(const addrinfo& target, absl::Duration timeout) {
  const int connection =
      socket(target.ai_family, target.ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (connection < 0) return -errno;
  int error = 0;
  if (connect(connection, target.ai_addr, target.ai_addrlen) != 0) {
    error = errno == EINPROGRESS ? WaitUntilConnected(connection, timeout) : errno;
  }
  if (error == 0) return connection;
  close(connection);
  return -error;
}

// The caller closes it.
absl::StatusOr<int> Connect(const std::string& address, absl::Duration timeout) {
  const size_t colon = address.rfind(':');
  if (colon == std::string::npos) return Unreachable(address, "is not HOST:PORT");
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* targets = nullptr;
  const int error =
      getaddrinfo(HostOf(address).c_str(), address.substr(colon + 1).c_str(), &hints, &targets);
  if (error != 0) return Unreachable(address, gai_strerror(error));
  const absl::Cleanup release = [&] { freeaddrinfo(targets); };
  int connection = -EHOSTUNREACH;
  for (const addrinfo* target = targets; target != nullptr && connection < 0;
       target = target->ai_next) {
    connection = ConnectOne(*target, timeout);
  }
  if (connection < 0) return Unreachable(address, std::strerror(-connection));
  return connection;
}

// From now on calls wait, at most so long.
void MakeBlocking(int connection, absl::Duration timeout) {
  fcntl(connection, F_SETFL, fcntl(connection, F_GETFL) & ~O_NONBLOCK);
  const timeval limit = absl::ToTimeval(timeout);
  setsockopt(connection, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof(limit));
  setsockopt(connection, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof(limit));
}

std::string ToPem(STACK_OF(X509) * chain) {
  const std::unique_ptr<BIO, decltype(&BIO_free)> bio(BIO_new(BIO_s_mem()), BIO_free);
  for (int i = 0; i < sk_X509_num(chain); ++i)
    PEM_write_bio_X509(bio.get(), sk_X509_value(chain, i));
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &data);
  return {data, static_cast<size_t>(size)};
}

}  // namespace

std::string HostOf(const std::string& address) {
  const std::string host = address.substr(0, address.rfind(':'));
  const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  return bracketed ? host.substr(1, host.size() - 2) : host;
}

absl::Status ProbeTcp(const std::string& address, absl::Duration timeout) {
  ASSIGN_OR_RETURN(const int connection, Connect(address, timeout));
  close(connection);
  return absl::OkStatus();
}

absl::StatusOr<std::string> FetchCertificates(const std::string& address, absl::Duration timeout) {
  ASSIGN_OR_RETURN(const int connection, Connect(address, timeout));
  const absl::Cleanup release = [&] { close(connection); };
  MakeBlocking(connection, timeout);
  // OpenSSL writes to connections that the other side has closed.
  const auto before = std::signal(SIGPIPE, SIG_IGN);
  const absl::Cleanup restore = [&] { std::signal(SIGPIPE, before); };
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context(SSL_CTX_new(TLS_client_method()),
                                                                  SSL_CTX_free);
  SSL_CTX_set_verify(context.get(), SSL_VERIFY_NONE, nullptr);
  // What gRPC speaks.
  constexpr unsigned char kHttp2[] = {2, 'h', '2'};
  SSL_CTX_set_alpn_protos(context.get(), kHttp2, sizeof(kHttp2));
  const std::unique_ptr<SSL, decltype(&SSL_free)> session(SSL_new(context.get()), SSL_free);
  SSL_set_fd(session.get(), connection);
  SSL_set_tlsext_host_name(session.get(), HostOf(address).c_str());
  const bool connected = SSL_connect(session.get()) == 1;
  ERR_clear_error();
  STACK_OF(X509)* chain = SSL_get_peer_cert_chain(session.get());
  // A server that wants a certificate of its caller may have shown its own already.
  if (chain == nullptr || sk_X509_num(chain) == 0) {
    return Unreachable(address, connected ? "shows no certificate" : "speaks no TLS");
  }
  return ToPem(chain);
}

}  // namespace corbslam
