// Listens for connections of HTTP clients.
#ifndef CORBSLAM_SERVICES_HTTP_HTTP_LISTENER_H_
#define CORBSLAM_SERVICES_HTTP_HTTP_LISTENER_H_

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace corbslam::services {

// Checks that an address is "HOST:PORT" with an IP address as HOST (IPv6 in brackets) and a port of
// 0 to 65535. INVALID_ARGUMENT otherwise.
absl::Status CheckHttpAddress(const std::string& address);

// Accepts connections on a context that its owner runs with one thread. Only that thread uses it
// once it accepts.
class HttpListener {
 public:
  using Serve = std::function<void(boost::asio::ip::tcp::socket)>;

  // `context` is not owned and must outlive it.
  explicit HttpListener(boost::asio::io_context& context)
      : acceptor_(context), before_next_try_(context) {}

  // Listens on an address that CheckHttpAddress takes; for port 0 the system chooses one. Returns
  // the address with the port that was chosen. UNAVAILABLE if it can't listen; the message says
  // why, and who has the port. Two listeners never share a port.
  absl::StatusOr<std::string> Listen(const std::string& address);
  // Calls `serve` for each connection, from now on.
  void Accept(Serve serve);

 private:
  void AcceptNext();
  void AcceptLater();

  boost::asio::ip::tcp::acceptor acceptor_;
  boost::asio::steady_timer before_next_try_;
  Serve serve_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_HTTP_HTTP_LISTENER_H_
