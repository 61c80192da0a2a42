// Runs a web server: HTTP/1.1 for operators and programs, and with BrowserOptions
// (browser_options.h) WebSockets and TLS, too.
#ifndef CORBSLAM_SERVICES_HTTP_WEB_SERVER_H_
#define CORBSLAM_SERVICES_HTTP_WEB_SERVER_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "services/http/web_message.h"
#include "services/runtime/connection_book.h"

namespace corbslam::services {

// Makes what serves a connection (web_connection.h).
class WebConnector;

// Bounds what strangers can take of this process. As it is: for what operators read.
struct WebServerOptions {
  // Null: requests over TCP, and who asks for a WebSocket has what stands there instead.
  std::shared_ptr<const WebConnector> connector = nullptr;
  // Names by which browsers may call it beside IP addresses and localhost (web_host.h); requests to
  // others get 421. Nullopt: any. With TLS the certificate says it, and browsers see to that.
  std::optional<std::vector<std::string>> hosts = std::nullopt;
  // Connections at one time; fewer where the process may not have as many files. Who asks at once
  // is answered at once; one on which nothing is under way makes room for a newer one.
  ConnectionLimits connections = {.all = 32, .of_host = 16};
  // Limit for a request's first line and headers together.
  uint32_t max_head_bytes = 8 << 10;
  // False: a connection ends with its answer, and within `first_patience` whatever its client does.
  bool keeps_alive = false;
  // Limit for TLS and a connection's first request.
  absl::Duration first_patience = absl::Seconds(10);
  // Limit for a further request to come, for a client to take any of what is written, and for an
  // open connection to ask nothing.
  absl::Duration patience = absl::Seconds(30);
  // Whether its thread has less of a processor than those that robots wait for.
  bool steps_behind = true;
  // WebSockets beyond these are refused with 503. Half of them may be of one host, a quarter of one
  // token.
  size_t max_streams = 0;
  // How often it is asked whether a WebSocket may stay.
  absl::Duration stay_interval = absl::Seconds(1);
};

// Checks that an address is "HOST:PORT" with an IP address as HOST (IPv6 in brackets) and a port of
// 0 to 65535. INVALID_ARGUMENT otherwise.
absl::Status CheckHttpAddress(const std::string& address);

// One thread of its own does everything and never waits for a client. Bodies of requests are not
// read, and a WebSocket's messages from a browser are passed over. Thread-safe.
class WebServer {
 public:
  // Listens on an address that CheckHttpAddress takes; for port 0 the system chooses one. `handler`
  // is not owned and must outlive the server. UNAVAILABLE if it can't listen; the message says why,
  // and who has the port. Two servers never share a port.
  static absl::StatusOr<std::unique_ptr<WebServer>> Start(const std::string& address,
                                                          WebHandler* handler,
                                                          const WebServerOptions& options = {});
  // Waits for a call of the handler that is under way, and for no client. Ends all connections;
  // WebSockets are closed with 1001 (going away) as far as that goes at once.
  virtual ~WebServer() = default;

  // Returns "HOST:PORT" with the port that was chosen.
  virtual const std::string& address() const = 0;
  virtual size_t streams() const = 0;
  virtual ConnectionCounts connections() const = 0;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_HTTP_WEB_SERVER_H_
