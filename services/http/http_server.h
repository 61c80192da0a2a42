// Runs a small HTTP/1.1 server for what operators read, which strangers may reach, too.
#ifndef CORBSLAM_SERVICES_HTTP_HTTP_SERVER_H_
#define CORBSLAM_SERVICES_HTTP_HTTP_SERVER_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "services/http/http_listener.h"
#include "services/http/http_message.h"
#include "services/runtime/connection_book.h"

namespace corbslam::services {

// Bounds what strangers can take of this process.
struct HttpServerOptions {
  // Most connections that are open at once, in all and of one host. The oldest of the host that has
  // most is closed for each further one: a client that sends its request at once is answered at
  // once, one that waits makes room for others.
  ConnectionLimits connections = {.all = 32, .of_host = 16};
  // Limit from the connection's beginning to the last byte of the answer.
  absl::Duration max_connection_time = absl::Seconds(10);
};

// A server without TLS and passwords. One thread of its own does everything and never waits for a
// client: it reads a request's head (8 KiB at most), answers it and closes the connection. The
// thread has less of a processor than those that robots wait for (LowerThreadPriority).
// Thread-safe.
class HttpServer {
 public:
  // Listens on an address that CheckHttpAddress takes; for port 0 the system chooses one.
  // UNAVAILABLE if it can't listen; the message says why, and who has the port. Two servers never
  // share a port.
  static absl::StatusOr<std::unique_ptr<HttpServer>> Start(const std::string& address,
                                                           HttpHandler handler,
                                                           const HttpServerOptions& options = {});
  // The destructor waits for a call of the handler that is under way, and for no client.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  // Returns "HOST:PORT" with the port that was chosen.
  const std::string& address() const { return address_; }

 private:
  class Loop;

  HttpServer(std::string address, std::unique_ptr<Loop> loop);

  const std::string address_;
  const std::unique_ptr<Loop> loop_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_HTTP_HTTP_SERVER_H_
