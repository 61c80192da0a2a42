#include "services/http/http_listener.h"

#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "services/runtime/address.h"
#include "services/runtime/listen_errors.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

using boost::asio::ip::tcp;
using Error = boost::system::error_code;

// Pause when the process has no file descriptor left for a connection.
constexpr auto kBeforeNextTry = std::chrono::milliseconds(100);

// Returns nullopt for what is not "HOST:PORT" with an IP address.
std::optional<tcp::endpoint> ParseEndpoint(absl::string_view address) {
  const absl::StatusOr<HostPort> parsed = ParseListenAddress(address);
  if (!parsed.ok()) return std::nullopt;
  Error error;
  const auto ip = boost::asio::ip::make_address(parsed->host, error);
  if (error) return std::nullopt;
  return tcp::endpoint(ip, static_cast<uint16_t>(parsed->port));
}

}  // namespace

absl::Status CheckHttpAddress(const std::string& address) {
  if (ParseEndpoint(address).has_value()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("address is \"", address,
                   "\", must be HOST:PORT with an IP address and a port of 0 to 65535"));
}

absl::StatusOr<std::string> HttpListener::Listen(const std::string& address) {
  RETURN_IF_ERROR(CheckHttpAddress(address));
  const tcp::endpoint endpoint = *ParseEndpoint(address);
  Error error;
  acceptor_.open(endpoint.protocol(), error);
  // Connections of the process before may still be ending; they don't keep the port from us.
  if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor_.bind(endpoint, error);
  if (!error) acceptor_.listen(boost::asio::socket_base::max_listen_connections, error);
  if (error) {
    return absl::UnavailableError(absl::StrCat("can't listen on \"", address,
                                               "\": ", ExplainBindError(address, error.value())));
  }
  return absl::StrCat(address.substr(0, address.rfind(':')), ":",
                      acceptor_.local_endpoint().port());
}

void HttpListener::Accept(Serve serve) {
  serve_ = std::move(serve);
  AcceptNext();
}

void HttpListener::AcceptNext() {
  acceptor_.async_accept([this](Error error, tcp::socket socket) {
    if (error) return AcceptLater();
    serve_(std::move(socket));
    AcceptNext();
  });
}

void HttpListener::AcceptLater() {
  before_next_try_.expires_after(kBeforeNextTry);
  before_next_try_.async_wait([this](Error) { AcceptNext(); });
}

}  // namespace corbslam::services
