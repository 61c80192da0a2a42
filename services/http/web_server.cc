#include "services/http/web_server.h"

#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <map>
#include <thread>
#include <utility>

#include "services/http/http_listener.h"
#include "services/http/web_connection.h"
#include "services/runtime/file_limit.h"
#include "slam/util/status_macros.h"
#include "slam/util/thread_priority.h"

namespace corbslam::services {
namespace {

// Priority is lowered as much as for the threads of look-ups: both hold locks that robots wait for.
constexpr int kStepsLower = 5;

// Half of the pages may be of one host, and a quarter of one token.
WorkLimits PageLimits(size_t pages) {
  return {.what = "pages",
          .all = pages,
          .of_caller = std::max<size_t>(1, pages / 2),
          .of_resource = std::max<size_t>(1, pages / 4)};
}

}  // namespace

// Holds the thread, and what only that thread touches once it runs.
class WebServer::Loop {
 public:
  Loop(WebHandler* handler, const WebServerOptions& options)
      : options_(options),
        shared_{*handler, options_, std::make_shared<LoopPoster>(&context_),
                WorkSlots(PageLimits(options_.max_streams))},
        connector_(options_.connector != nullptr ? options_.connector : PlainConnector()),
        listener_(context_) {}
  ~Loop() {
    shared_.poster->End();
    context_.stop();
    if (thread_.joinable()) thread_.join();
    for (const auto& [id, weak] : open_) {
      if (const auto connection = weak.lock()) connection->Close();
    }
  }

  absl::StatusOr<std::string> Listen(const std::string& address) {
    return listener_.Listen(address);
  }
  void Start() {
    listener_.Accept([this](boost::asio::ip::tcp::socket socket) { Serve(std::move(socket)); });
    thread_ = std::thread([this] {
      if (options_.steps_behind) StepBehindRobots(kStepsLower, "scrapes");
      context_.run();
    });
  }
  size_t streams() const { return shared_.streams; }
  ConnectionCounts connections() const {
    return {.open = open_count_,
            .busy = busy_count_,
            .limits = LimitsWithin(FileLimit(), options_.connections),
            .refused = refused_,
            .closed_for_room = closed_for_room_};
  }

 private:
  void Serve(boost::asio::ip::tcp::socket socket) {
    Sweep();
    boost::system::error_code error;
    const boost::asio::ip::tcp::endpoint end = socket.remote_endpoint(error);
    if (error) return;
    const WebPeer peer = {next_id_++, HostOfIp(end.address().to_string())};
    const ConnectionBook::Verdict verdict =
        shared_.book.Enter(peer.id, peer.host, LimitsWithin(FileLimit(), options_.connections));
    refused_ += verdict.taken ? 0 : 1;
    if (!verdict.taken) return;
    if (verdict.makes_room.has_value()) MakeRoom(*verdict.makes_room);
    boost::system::error_code ignored;
    socket.set_option(boost::asio::ip::tcp::no_delay(true), ignored);
    const auto connection = connector_->Connect(std::move(socket), peer, shared_);
    open_.emplace(peer.id, connection);
    Count();
    connection->Start();
  }

  void Sweep() {
    std::erase_if(open_, [this](const auto& entry) {
      if (entry.second.expired()) shared_.book.Leave(entry.first);
      return entry.second.expired();
    });
    Count();
  }

  void Count() {
    open_count_ = shared_.book.size();
    busy_count_ = shared_.book.busy();
  }

  void MakeRoom(ConnectionBook::Id id) {
    ++closed_for_room_;
    const auto found = open_.find(id);
    if (found == open_.end()) return;
    if (const auto connection = found->second.lock()) connection->Close();
    open_.erase(found);
  }

  const WebServerOptions options_;
  WebShared shared_;
  const std::shared_ptr<const WebConnector> connector_;
  boost::asio::io_context context_{/*concurrency_hint=*/1};
  HttpListener listener_;
  ConnectionBook::Id next_id_ = 1;
  std::map<ConnectionBook::Id, std::weak_ptr<WebConnection>> open_;
  // Counted when a connection comes.
  std::atomic<size_t> open_count_ = 0;
  std::atomic<size_t> busy_count_ = 0;
  std::atomic<uint64_t> refused_ = 0;
  std::atomic<uint64_t> closed_for_room_ = 0;
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

ConnectionCounts WebServer::connections() const { return loop_->connections(); }

}  // namespace corbslam::services
