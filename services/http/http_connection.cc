#include "services/http/http_connection.h"

#include <glog/logging.h>

#include <algorithm>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>
#include <chrono>
#include <cstdint>
#include <exception>
#include <limits>
#include <string>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace corbslam::services {
namespace {

namespace beast = boost::beast;
namespace http = boost::beast::http;

// Longest time for a client to read its answer once the system has all of it.
constexpr auto kDrainTime = std::chrono::seconds(1);

// Returns the path of "/path?query", or of "http://host/path?query" as a proxy would send it.
std::string PathOf(absl::string_view target) {
  const size_t scheme = target.find("://");
  if (!absl::StartsWith(target, "/") && scheme != absl::string_view::npos) {
    const size_t path = target.find('/', scheme + 3);
    target = path == absl::string_view::npos ? "/" : target.substr(path);
  }
  return std::string(target.substr(0, target.find_first_of("?#")));
}

absl::string_view View(boost::beast::string_view text) { return {text.data(), text.size()}; }

}  // namespace

HttpConnection::HttpConnection(boost::asio::ip::tcp::socket socket, const HttpHandler* handler)
    : stream_(std::move(socket)), handler_(*handler) {
  parser_.header_limit(kMaxHeadBytes);
  // A body is not read, so that any length of it is allowed.
  parser_.body_limit(std::numeric_limits<uint64_t>::max());
}

void HttpConnection::Start(absl::Duration max_time) {
  stream_.expires_after(absl::ToChronoNanoseconds(max_time));
  http::async_read_header(
      stream_, head_, parser_,
      [self = shared_from_this()](Error error, size_t) { self->OnHead(error); });
}

void HttpConnection::Close() { stream_.close(); }

void HttpConnection::OnHead(Error error) {
  if (!error) return Write(Handle());
  const HttpResponse answer = DescribeBadHead(error);
  if (answer.status != 0) Write(answer);
}

HttpResponse HttpConnection::DescribeBadHead(Error error) const {
  const bool is_of_parser = error.category() == make_error_code(http::error::bad_method).category();
  if (!is_of_parser || error == http::error::end_of_stream ||
      error == http::error::partial_message) {
    return {.status = 0};
  }
  if (error != http::error::header_limit && error != http::error::buffer_overflow) {
    return {.status = 400, .body = absl::StrCat("this is no HTTP/1.1: ", error.message(), "\n")};
  }
  // The parser takes the first line only as a whole, so that a long one leaves no target.
  if (parser_.get().target().empty()) {
    return {.status = 414,
            .body = absl::StrCat("the first line has over ", kMaxHeadBytes, " bytes\n")};
  }
  return {.status = 431, .body = absl::StrCat("the headers have over ", kMaxHeadBytes, " bytes\n")};
}

HttpResponse HttpConnection::Handle() const {
  const auto& request = parser_.get();
  try {
    return handler_({std::string(View(request.method_string())), PathOf(View(request.target()))});
  } catch (const std::exception& error) {
    LOG(ERROR) << "an HTTP request ended with " << error.what();
    return {.status = 500, .body = "the answer could not be made\n"};
  }
}

void HttpConnection::Write(const HttpResponse& answer) {
  response_.version(11);
  response_.result(static_cast<unsigned>(answer.status));
  response_.keep_alive(false);
  response_.set(http::field::content_type, answer.content_type);
  if (!answer.allow.empty()) response_.set(http::field::allow, answer.allow);
  response_.content_length(answer.body.size());
  // The answer to HEAD has the length of what GET would bring.
  if (parser_.get().method() != http::verb::head) response_.body() = answer.body;
  http::async_write(stream_, response_,
                    [self = shared_from_this()](Error error, size_t) { self->OnWritten(error); });
}

void HttpConnection::OnWritten(Error error) {
  if (error) return;
  stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, error);
  stream_.expires_after(kDrainTime);
  Drain();
}

void HttpConnection::Drain() {
  stream_.async_read_some(boost::asio::buffer(rest_),
                          [self = shared_from_this()](Error error, size_t) {
                            if (!error) self->Drain();
                          });
}

}  // namespace corbslam::services
