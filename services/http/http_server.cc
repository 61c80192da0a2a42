#include "services/http/http_server.h"

#include <glog/logging.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <deque>
#include <optional>
#include <thread>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "services/http/http_connection.h"
#include "services/runtime/listen_errors.h"
#include "slam/util/status_macros.h"
#include "slam/util/thread_priority.h"

namespace corbslam::services {
namespace {

using boost::asio::ip::tcp;
using Error = boost::system::error_code;

// Priority is lowered as much as for the threads of look-ups: both hold locks that robots wait for.
constexpr int kStepsLower = 5;
// Pause when the process has no file descriptor left for a connection.
constexpr auto kBeforeNextTry = std::chrono::milliseconds(100);

// Returns nullopt for what is not "HOST:PORT" with an IP address.
std::optional<tcp::endpoint> ParseEndpoint(absl::string_view address) {
  const size_t colon = address.rfind(':');
  int port = 0;
  if (colon == absl::string_view::npos || !absl::SimpleAtoi(address.substr(colon + 1), &port) ||
      port < 0 || port > 65535 || address.substr(colon + 1).find_first_of("+- ") == 0) {
    return std::nullopt;
  }
  absl::string_view host = address.substr(0, colon);
  const bool in_brackets = absl::ConsumePrefix(&host, "[") && absl::ConsumeSuffix(&host, "]");
  Error error;
  const auto ip = boost::asio::ip::make_address(std::string(host), error);
  if (error || ip.is_v6() != in_brackets) return std::nullopt;
  return tcp::endpoint(ip, static_cast<uint16_t>(port));
}

}  // namespace

absl::Status CheckHttpAddress(const std::string& address) {
  if (ParseEndpoint(address).has_value()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("address is \"", address,
                   "\", must be HOST:PORT with an IP address and a port of 0 to 65535"));
}

// Holds the thread, and what only that thread touches once it runs.
class HttpServer::Loop {
 public:
  Loop(HttpHandler handler, const HttpServerOptions& options)
      : options_(options),
        handler_(std::move(handler)),
        acceptor_(context_),
        before_next_try_(context_) {}
  ~Loop() {
    context_.stop();
    if (thread_.joinable()) thread_.join();
  }

  Error Listen(const tcp::endpoint& endpoint) {
    Error error;
    acceptor_.open(endpoint.protocol(), error);
    // Connections of the process before may still be ending; they don't keep the port from us.
    if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(boost::asio::socket_base::max_listen_connections, error);
    return error;
  }
  uint16_t port() const { return acceptor_.local_endpoint().port(); }

  void Start() {
    Accept();
    thread_ = std::thread([this] {
      const absl::Status lowered = LowerThreadPriority(kStepsLower);
      LOG_IF(WARNING, !lowered.ok()) << "scrapes may hold up robots: " << lowered;
      context_.run();
    });
  }

 private:
  void Accept() {
    acceptor_.async_accept([this](Error error, tcp::socket socket) {
      if (error) return AcceptLater();
      Serve(std::move(socket));
      Accept();
    });
  }

  void AcceptLater() {
    before_next_try_.expires_after(kBeforeNextTry);
    before_next_try_.async_wait([this](Error) { Accept(); });
  }

  void Serve(tcp::socket socket) {
    std::erase_if(open_, [](const auto& connection) { return connection.expired(); });
    while (open_.size() >= options_.max_connections) {
      if (const auto oldest = open_.front().lock()) oldest->Close();
      open_.pop_front();
    }
    const auto connection = std::make_shared<HttpConnection>(std::move(socket), &handler_);
    open_.push_back(connection);
    connection->Start(options_.max_connection_time);
  }

  const HttpServerOptions options_;
  const HttpHandler handler_;
  boost::asio::io_context context_{/*concurrency_hint=*/1};
  tcp::acceptor acceptor_;
  boost::asio::steady_timer before_next_try_;
  std::deque<std::weak_ptr<HttpConnection>> open_;  // The oldest comes first.
  std::thread thread_;
};

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::Start(const std::string& address,
                                                              HttpHandler handler,
                                                              const HttpServerOptions& options) {
  RETURN_IF_ERROR(CheckHttpAddress(address));
  auto loop = std::make_unique<Loop>(std::move(handler), options);
  const Error error = loop->Listen(*ParseEndpoint(address));
  if (error) {
    return absl::UnavailableError(absl::StrCat("can't listen on \"", address,
                                               "\": ", ExplainBindError(address, error.value())));
  }
  std::string listening = absl::StrCat(address.substr(0, address.rfind(':')), ":", loop->port());
  std::unique_ptr<HttpServer> server(new HttpServer(std::move(listening), std::move(loop)));
  server->loop_->Start();
  return server;
}

HttpServer::HttpServer(std::string address, std::unique_ptr<Loop> loop)
    : address_(std::move(address)), loop_(std::move(loop)) {}

HttpServer::~HttpServer() = default;

}  // namespace corbslam::services
