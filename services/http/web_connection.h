// Serves one connection of a client, from its acceptance to its end.
#ifndef CORBSLAM_SERVICES_HTTP_WEB_CONNECTION_H_
#define CORBSLAM_SERVICES_HTTP_WEB_CONNECTION_H_

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "services/http/web_message.h"
#include "services/http/web_server.h"
#include "services/runtime/connection_book.h"
#include "services/server/work_slots.h"

namespace corbslam::services {

// Runs functions on a server's thread, from any thread, until the server ends. Thread-safe.
class LoopPoster {
 public:
  explicit LoopPoster(boost::asio::io_context* context) : context_(context) {}

  // Does nothing once the server has ended.
  void Post(std::function<void()> function);
  void End();

 private:
  absl::Mutex mutex_;
  boost::asio::io_context* context_ ABSL_GUARDED_BY(mutex_);
};

// What all connections of a server share; it outlives them.
struct WebShared {
  WebHandler& handler;
  const WebServerOptions& options;
  const std::shared_ptr<LoopPoster> poster;
  WorkSlots pages;
  std::atomic<size_t> streams = 0;
  // Only the server's thread uses it.
  ConnectionBook book = {};
};

// Whose a connection is.
struct WebPeer {
  ConnectionBook::Id id = 0;
  std::string host;
};

// Says, as long as it lives, that something is under way on a connection.
class WebUse {
 public:
  WebUse(WebShared& shared, ConnectionBook::Id id) : shared_(shared), id_(id) {
    shared_.book.Begin(id_);
  }
  ~WebUse() { shared_.book.End(id_); }
  WebUse(const WebUse&) = delete;
  WebUse& operator=(const WebUse&) = delete;

 private:
  WebShared& shared_;
  const ConnectionBook::Id id_;
};

// A connection lives as long as one of its operations is under way, or an answer is awaited.
class WebConnection {
 public:
  virtual ~WebConnection() = default;
  // Begins to serve; called once.
  virtual void Start() = 0;
  // Gives up whatever is under way.
  virtual void Close() = 0;
};

class WebConnector {
 public:
  virtual ~WebConnector() = default;
  virtual std::shared_ptr<WebConnection> Connect(boost::asio::ip::tcp::socket socket, WebPeer peer,
                                                 WebShared& shared) const = 0;
};

std::shared_ptr<const WebConnector> PlainConnector();

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_HTTP_WEB_CONNECTION_H_
