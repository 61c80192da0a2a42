#include "services/http/http_server.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <map>
#include <thread>
#include <utility>

#include "services/http/http_connection.h"
#include "services/http/http_listener.h"
#include "services/runtime/file_limit.h"
#include "slam/util/status_macros.h"
#include "slam/util/thread_priority.h"

namespace corbslam::services {
namespace {

using boost::asio::ip::tcp;

// Priority is lowered as much as for the threads of look-ups: both hold locks that robots wait for.
constexpr int kStepsLower = 5;

}  // namespace

// Holds the thread, and what only that thread touches once it runs.
class HttpServer::Loop {
 public:
  Loop(HttpHandler handler, const HttpServerOptions& options)
      : options_(options), handler_(std::move(handler)), listener_(context_) {}
  ~Loop() {
    context_.stop();
    if (thread_.joinable()) thread_.join();
  }

  absl::StatusOr<std::string> Listen(const std::string& address) {
    return listener_.Listen(address);
  }

  void Start() {
    listener_.Accept([this](tcp::socket socket) { Serve(std::move(socket)); });
    thread_ = std::thread([this] {
      StepBehindRobots(kStepsLower, "scrapes");
      context_.run();
    });
  }

 private:
  void Serve(tcp::socket socket) {
    std::erase_if(open_, [this](const auto& entry) {
      if (entry.second.expired()) book_.Leave(entry.first);
      return entry.second.expired();
    });
    boost::system::error_code error;
    const tcp::endpoint peer = socket.remote_endpoint(error);
    if (error) return;
    const ConnectionBook::Id id = next_id_++;
    const ConnectionBook::Verdict verdict = book_.Enter(
        id, HostOfIp(peer.address().to_string()), LimitsWithin(FileLimit(), options_.connections));
    if (verdict.makes_room.has_value()) {
      const auto oldest = open_.find(*verdict.makes_room);
      if (const auto connection = oldest->second.lock()) connection->Close();
      open_.erase(oldest);
    }
    const auto connection = std::make_shared<HttpConnection>(std::move(socket), &handler_);
    open_.emplace(id, connection);
    connection->Start(options_.max_connection_time);
  }

  const HttpServerOptions options_;
  const HttpHandler handler_;
  boost::asio::io_context context_{/*concurrency_hint=*/1};
  HttpListener listener_;
  ConnectionBook book_;
  ConnectionBook::Id next_id_ = 1;
  std::map<ConnectionBook::Id, std::weak_ptr<HttpConnection>> open_;
  std::thread thread_;
};

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::Start(const std::string& address,
                                                              HttpHandler handler,
                                                              const HttpServerOptions& options) {
  auto loop = std::make_unique<Loop>(std::move(handler), options);
  ASSIGN_OR_RETURN(std::string listening, loop->Listen(address));
  std::unique_ptr<HttpServer> server(new HttpServer(std::move(listening), std::move(loop)));
  server->loop_->Start();
  return server;
}

HttpServer::HttpServer(std::string address, std::unique_ptr<Loop> loop)
    : address_(std::move(address)), loop_(std::move(loop)) {}

HttpServer::~HttpServer() = default;

}  // namespace corbslam::services
