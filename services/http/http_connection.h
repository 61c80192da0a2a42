// Serves one connection to an HTTP server, from its acceptance to its end.
#ifndef CORBSLAM_SERVICES_HTTP_HTTP_CONNECTION_H_
#define CORBSLAM_SERVICES_HTTP_HTTP_CONNECTION_H_

#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_static_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <cstddef>
#include <memory>

#include "absl/time/time.h"
#include "services/http/http_message.h"

namespace corbslam::services {

// Reads the head of one request, answers it, and closes. It lives as long as one of its operations
// is under way. Only the one thread that runs the socket's context may use it.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  // Limit for a request's first line and headers together.
  static constexpr size_t kMaxHeadBytes = 8 << 10;

  // `handler` is not owned and must outlive the context's run.
  HttpConnection(boost::asio::ip::tcp::socket socket, const HttpHandler* handler);

  // Begins to serve. The caller calls it once. Everything ends within `max_time`.
  void Start(absl::Duration max_time);
  // Gives up whatever is under way.
  void Close();

 private:
  using Error = boost::beast::error_code;

  void OnHead(Error error);
  // Returns the answer to a head that could not be read; status 0 means none, since nobody listens.
  HttpResponse DescribeBadHead(Error error) const;
  HttpResponse Handle() const;
  void Write(const HttpResponse& answer);
  void OnWritten(Error error);
  // Reads what still comes and forgets it: if the connection were closed at once, the system would
  // take back from the client what it has not read of the answer.
  void Drain();

  boost::beast::tcp_stream stream_;
  const HttpHandler& handler_;
  boost::beast::flat_static_buffer<kMaxHeadBytes> head_;
  boost::beast::http::request_parser<boost::beast::http::empty_body> parser_;
  boost::beast::http::response<boost::beast::http::string_body> response_;
  std::array<char, 4096> rest_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_HTTP_HTTP_CONNECTION_H_
