// Serves one connection of a browser, over TCP or TLS, from its acceptance to its end.
#ifndef CORBSLAM_SERVICES_VIEWER_WEB_WEB_CONNECTION_H_
#define CORBSLAM_SERVICES_VIEWER_WEB_WEB_CONNECTION_H_

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "services/runtime/connection_book.h"
#include "services/server/work_slots.h"
#include "services/viewer/web/web_message.h"
#include "services/viewer/web/web_server.h"

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

class WebConnection {
 public:
  virtual ~WebConnection() = default;
  // Begins to serve; called once.
  virtual void Start() = 0;
  // Gives up whatever is under way.
  virtual void Close() = 0;
};

// A connection lives as long as one of its operations is under way, or an answer is awaited. It
// goes by the key pair that the options' TLS has now; without TLS: over TCP.
std::shared_ptr<WebConnection> MakeWebConnection(boost::asio::ip::tcp::socket socket, WebPeer peer,
                                                 WebShared& shared);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_VIEWER_WEB_WEB_CONNECTION_H_
