// A WebSocket client for tests.
#ifndef CORBSLAM_SERVICES_HTTP_TESTING_WEB_CLIENT_H_
#define CORBSLAM_SERVICES_HTTP_TESTING_WEB_CLIENT_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/time/time.h"

namespace corbslam::testing {

struct SocketOptions {
  std::string origin = {};  // Empty: none.
  std::string protocols = "corbslam";
  bool tls = false;  // Certificates are not looked at.
};

// Connects, and reads binary messages. Not thread-safe.
class WebSocketClient {
 public:
  // `address` is "IP:PORT".
  WebSocketClient(const std::string& address, const std::string& target,
                  const SocketOptions& options = {});
  ~WebSocketClient();

  // Returns true if the server has taken the handshake.
  bool stands() const;
  // Returns the protocol that the server has chosen.
  std::string protocol() const;
  // Returns the next message; nullopt: the socket was closed, or none came in time.
  std::optional<std::string> Read(absl::Duration patience = absl::Seconds(20));
  // Returns the code with which the server has closed the socket; 0: it has not.
  uint16_t close_code() const;
  // Returns the certificate that the server has shown, as PEM; empty without TLS.
  std::string certificate() const;
  bool Send(const std::string& text);

 private:
  class Impl;

  const std::unique_ptr<Impl> impl_;
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_SERVICES_HTTP_TESTING_WEB_CLIENT_H_
