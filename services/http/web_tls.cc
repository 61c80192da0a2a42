#include "services/http/web_tls.h"

#include <boost/asio/buffer.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

using TlsContext = boost::asio::ssl::context;

absl::StatusOr<std::shared_ptr<TlsContext>> MakeContext(const std::string& certificate_pem,
                                                        const std::string& key_pem) {
  auto tls = std::make_shared<TlsContext>(TlsContext::tls_server);
  boost::system::error_code error;
  tls->set_options(TlsContext::default_workarounds | TlsContext::no_sslv2 | TlsContext::no_sslv3 |
                   TlsContext::no_tlsv1 | TlsContext::no_tlsv1_1);
  tls->use_certificate_chain(boost::asio::buffer(certificate_pem), error);
  if (!error) {
    tls->use_private_key(boost::asio::buffer(key_pem), TlsContext::pem, error);
  }
  if (!error) return tls;
  return absl::InvalidArgumentError(
      absl::StrCat("TLS: the key pair can't be used: ", error.message()));
}

}  // namespace

absl::StatusOr<std::unique_ptr<WebTls>> WebTls::Make(const std::string& certificate_pem,
                                                     const std::string& key_pem) {
  ASSIGN_OR_RETURN(std::shared_ptr<TlsContext> context, MakeContext(certificate_pem, key_pem));
  return std::unique_ptr<WebTls>(new WebTls(std::move(context)));
}

absl::Status WebTls::Replace(const std::string& certificate_pem, const std::string& key_pem) {
  ASSIGN_OR_RETURN(std::shared_ptr<TlsContext> context, MakeContext(certificate_pem, key_pem));
  absl::MutexLock lock(&mutex_);
  context_ = std::move(context);
  return absl::OkStatus();
}

std::shared_ptr<TlsContext> WebTls::context() const {
  absl::MutexLock lock(&mutex_);
  return context_;
}

}  // namespace corbslam::services
