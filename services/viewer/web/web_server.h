// Runs a web server for browsers: HTTP/1.1 and WebSockets, with TLS or without.
#ifndef CORBSLAM_SERVICES_VIEWER_WEB_WEB_SERVER_H_
#define CORBSLAM_SERVICES_VIEWER_WEB_WEB_SERVER_H_

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "services/runtime/connection_book.h"
#include "services/server/served_ports.h"
#include "services/viewer/web/web_message.h"
#include "services/viewer/web/web_tls.h"

namespace corbslam::services {

struct WebServerOptions {
  // Null: no TLS. It may be replaced while the server runs.
  std::shared_ptr<const WebTls> tls = nullptr;
  // Names by which browsers may call it beside IP addresses and localhost (web_host.h); requests to
  // others get 421. Nullopt: any. With TLS the certificate says it, and browsers see to that.
  std::optional<std::vector<std::string>> hosts = std::nullopt;
  // Connections at one time; fewer where the process may not have as many files. One on which
  // nothing is under way makes room for a newer one.
  ConnectionLimits connections = {.all = 1024, .of_host = 512};
  // WebSockets beyond these are refused with 503. Half of them may be of one host, a quarter of one
  // token.
  size_t max_streams = 100;
  // Limit for TLS and a connection's first request.
  absl::Duration first_patience = absl::Seconds(10);
  // How often it is asked whether a WebSocket may stay.
  absl::Duration stay_interval = absl::Seconds(1);
  // Limit for a request to come, for a client to take any of what is written, and for an open
  // connection to ask nothing.
  absl::Duration patience = absl::Seconds(30);
};

// One thread of its own does everything and never waits for a client. A request's head has 16 KiB
// at most, bodies are refused, and a WebSocket's messages from a browser are passed over.
// Thread-safe.
class WebServer {
 public:
  // Listens on an address that CheckHttpAddress takes; for port 0 the system chooses one. `handler`
  // is not owned and must outlive the server. UNAVAILABLE if it can't listen, with why.
  static absl::StatusOr<std::unique_ptr<WebServer>> Start(const std::string& address,
                                                          WebHandler* handler,
                                                          const WebServerOptions& options = {});
  // Ends all connections; WebSockets are closed with 1001 (going away) as far as that goes at once.
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  // Returns "HOST:PORT" with the port that was chosen.
  const std::string& address() const { return address_; }
  size_t streams() const;
  ConnectionCounts connections() const;

 private:
  class Loop;

  WebServer(std::string address, std::unique_ptr<Loop> loop);

  const std::string address_;
  const std::unique_ptr<Loop> loop_;
  const ServedPort port_{"web", [this] { return connections(); }};
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_VIEWER_WEB_WEB_SERVER_H_
