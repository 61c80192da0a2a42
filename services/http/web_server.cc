#include "services/http/web_server.h"

#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <map>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "services/http/web_connection.h"
#include "services/runtime/address.h"
#include "services/runtime/file_limit.h"
#include "services/runtime/listen_errors.h"
#include "slam/util/named_thread.h"
#include "slam/util/status_macros.h"
#include "slam/util/thread_priority.h"

namespace corbslam::services {
namespace {

using boost::asio::ip::tcp;
using Error = boost::system::error_code;

// Pause when the process has no file descriptor left for a connection.
constexpr auto kBeforeNextTry = std::chrono::milliseconds(100);
// Priority is lowered as much as for the threads of look-ups: both hold locks that robots wait for.
constexpr int kStepsLower = 5;

absl::StatusOr<tcp::endpoint> ParseEndpoint(const std::string& address) {
  const absl::StatusOr<HostPort> parsed = ParseListenAddress(address);
  Error error;
  const auto ip = boost::asio::ip::make_address(parsed.ok() ? parsed->host : "", error);
  if (!error) return tcp::endpoint(ip, static_cast<uint16_t>(parsed->port));
  return absl::InvalidArgumentError(
      absl::StrCat("address is \"", address,
                   "\", must be HOST:PORT with an IP address and a port of 0 to 65535"));
}

// Half of the pages may be of one host, and a quarter of one token.
WorkLimits PageLimits(size_t pages) {
  return {.what = "pages",
          .all = pages,
          .of_caller = std::max<size_t>(1, pages / 2),
          .of_resource = std::max<size_t>(1, pages / 4)};
}

// Holds the thread, and what only that thread touches once it runs.
class WebLoop : public WebServer {
 public:
  WebLoop(WebHandler* handler, const WebServerOptions& options)
      : options_(options),
        shared_{*handler, options_, std::make_shared<LoopPoster>(&context_),
                WorkSlots(PageLimits(options_.max_streams))},
        connector_(options_.connector != nullptr ? options_.connector : PlainConnector()),
        acceptor_(context_),
        before_next_try_(context_) {}
  ~WebLoop() override {
    shared_.poster->End();
    context_.stop();
    if (thread_.joinable()) thread_.join();
    for (const auto& [id, weak] : open_) {
      if (const auto connection = weak.lock()) connection->Close();
    }
  }

  absl::Status Listen(const std::string& address) {
    ASSIGN_OR_RETURN(const tcp::endpoint endpoint, ParseEndpoint(address));
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
    address_ =
        absl::StrCat(address.substr(0, address.rfind(':')), ":", acceptor_.local_endpoint().port());
    return absl::OkStatus();
  }
  void Run() {
    AcceptNext();
    thread_ = StartThread("http", [this] {
      if (options_.steps_behind) StepBehindRobots(kStepsLower, "scrapes");
      context_.run();
    });
  }

  const std::string& address() const override { return address_; }
  size_t streams() const override { return shared_.streams; }
  ConnectionCounts connections() const override {
    return {.open = open_count_,
            .busy = busy_count_,
            .limits = LimitsWithin(FileLimit(), options_.connections),
            .refused = refused_,
            .closed_for_room = closed_for_room_};
  }

 private:
  void AcceptNext() {
    acceptor_.async_accept([this](Error error, tcp::socket socket) {
      if (error) return AcceptLater();
      Serve(std::move(socket));
      AcceptNext();
    });
  }

  void AcceptLater() {
    before_next_try_.expires_after(kBeforeNextTry);
    before_next_try_.async_wait([this](Error) { AcceptNext(); });
  }

  void Serve(tcp::socket socket) {
    Sweep();
    Error error;
    const tcp::endpoint end = socket.remote_endpoint(error);
    if (error) return;
    const WebPeer peer = {next_id_++, HostOfIp(end.address().to_string())};
    const ConnectionBook::Verdict verdict =
        shared_.book.Enter(peer.id, peer.host, LimitsWithin(FileLimit(), options_.connections));
    refused_ += verdict.taken ? 0 : 1;
    if (!verdict.taken) return;
    if (verdict.makes_room.has_value()) MakeRoom(*verdict.makes_room);
    Error ignored;
    socket.set_option(tcp::no_delay(true), ignored);
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
  tcp::acceptor acceptor_;
  boost::asio::steady_timer before_next_try_;
  std::string address_;
  ConnectionBook::Id next_id_ = 1;
  std::map<ConnectionBook::Id, std::weak_ptr<WebConnection>> open_;
  // Counted when a connection comes.
  std::atomic<size_t> open_count_ = 0;
  std::atomic<size_t> busy_count_ = 0;
  std::atomic<uint64_t> refused_ = 0;
  std::atomic<uint64_t> closed_for_room_ = 0;
  std::thread thread_;
};

}  // namespace

absl::Status CheckHttpAddress(const std::string& address) {
  return ParseEndpoint(address).status();
}

absl::StatusOr<std::unique_ptr<WebServer>> WebServer::Start(const std::string& address,
                                                            WebHandler* handler,
                                                            const WebServerOptions& options) {
  auto server = std::make_unique<WebLoop>(handler, options);
  RETURN_IF_ERROR(server->Listen(address));
  server->Run();
  return server;
}

}  // namespace corbslam::services
