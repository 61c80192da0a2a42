#include "services/viewer/web/web_server.h"

#include <boost/asio/io_context.hpp>
#include <deque>
#include <thread>
#include <utility>

#include "services/http/http_listener.h"
#include "services/viewer/web/web_connection.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
// Holds the thread, and what only that thread touches once it runs.
class WebServer::Loop {
 public:
  Loop(WebHandler* handler, const WebServerOptions& options)
      : options_(options),
        shared_{*handler, options_, std::make_shared<LoopPoster>(&context_)},
        listener_(context_) {}
  ~Loop() {
    shared_.poster->End();
    context_.stop();
    if (thread_.joinable()) thread_.join();
    for (const auto& weak : open_) {
      if (const auto connection = weak.lock()) connection->Close();
    }
  }

  absl::StatusOr<std::string> Listen(const std::string& address) {
    return listener_.Listen(address);
  }
  void Start() {
    listener_.Accept([this](boost::asio::ip::tcp::socket socket) { Serve(std::move(socket)); });
    thread_ = std::thread([this] { context_.run(); });
  }
  size_t streams() const { return shared_.streams; }

 private:
  void Serve(boost::asio::ip::tcp::socket socket) {
    std::erase_if(open_, [](const auto& connection) { return connection.expired(); });
    if (open_.size() >= options_.max_connections) return;
    boost::system::error_code ignored;
    socket.set_option(boost::asio::ip::tcp::no_delay(true), ignored);
    const auto connection = MakeWebConnection(std::move(socket), shared_);
    open_.push_back(connection);
    connection->Start();
  }

  const WebServerOptions options_;
  WebShared shared_;
  boost::asio::io_context context_{/*concurrency_hint=*/1};
  HttpListener listener_;
  std::deque<std::weak_ptr<WebConnection>> open_;
  std::thread thread_;
};

absl::StatusOr<std::unique_ptr<WebServer>> WebServer::Start(const std::string& address,
                                                            WebHandler* handler,
                                                            const WebServerOptions& options) {
  auto loop = std::make_unique<Loop>(handler, options);
  ASSIGN_OR_RETURN(std::string listening, loop->Listen(address));
  std::unique_ptr<WebServer> server(new WebServer(std::move(listening), std::move(loop)));
  server->loop_->Start();
  return server;
}

WebServer::WebServer(std::string address, std::unique_ptr<Loop> loop)
    : address_(std::move(address)), loop_(std::move(loop)) {}

WebServer::~WebServer() = default;

size_t WebServer::streams() const { return loop_->streams(); }

}  // namespace corbslam::services
