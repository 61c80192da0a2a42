// Reads requests on one connection and writes answers, until a WebSocket takes over.
#ifndef CORBSLAM_SERVICES_HTTP_WEB_SESSION_H_
#define CORBSLAM_SERVICES_HTTP_WEB_SESSION_H_

#include <glog/logging.h>

#include <algorithm>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/span_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <exception>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "services/http/web_connection.h"
#include "services/http/web_socket.h"

namespace corbslam::services {

using TcpStream = boost::beast::tcp_stream;
using RequestHead = boost::beast::http::request<boost::beast::http::empty_body>;

// Sets what a head says. Returns why it is refused; nullopt: it is not.
std::optional<WebResponse> ReadRequest(const RequestHead& head, const WebServerOptions& options,
                                       WebRequest& request);
// Returns the answer to a head that could not be read; nullopt: nobody listens.
std::optional<WebResponse> DescribeReadError(boost::beast::error_code error,
                                             const RequestHead& head, size_t max_head_bytes);
// Returns true unless a page of another site asks.
bool IsOfSameSite(const RequestHead& head);

// `Stream` is TcpStream, or TLS over it. Only the server's thread uses it.
template <typename Stream, bool kOpensWebSockets>
class WebSession : public WebConnection,
                   public std::enable_shared_from_this<WebSession<Stream, kOpensWebSockets>> {
 public:
  WebSession(Stream stream, WebPeer peer, WebShared& shared)
      : stream_(std::move(stream)), peer_(std::move(peer)), shared_(shared) {}

  void Start() override {
    SetPatience(std::min(shared_.options.first_patience, shared_.options.patience));
    if constexpr (std::is_same_v<Stream, TcpStream>) {
      Read();
    } else {
      stream_.async_handshake(Stream::server, [self = this->shared_from_this()](Error error) {
        if (!error) self->Read();
      });
    }
  }
  void Close() override {
    // It may be all that keeps this.
    const std::shared_ptr<WebSession> kept = std::move(awaiting_);
    use_.reset();
    holding_back_.reset();
    if (const auto socket = socket_.lock()) return socket->Close();
    Below().close();
  }

 private:
  using Error = boost::beast::error_code;

  // Longest time for a client to read its last answer once the system has all of it.
  static constexpr absl::Duration kDrainTime = absl::Seconds(1);
  static constexpr size_t kDrainedAtOnce = 4096;

  TcpStream& Below() { return boost::beast::get_lowest_layer(stream_); }
  void SetPatience(absl::Duration patience) {
    Below().expires_after(absl::ToChronoNanoseconds(patience));
  }
  // One deadline is for all of a connection that is not kept.
  void RenewPatience() {
    if (shared_.options.keeps_alive) SetPatience(shared_.options.patience);
  }

  void Read() {
    parser_.emplace();
    parser_->header_limit(shared_.options.max_head_bytes);
    // A body is not read, so that any length of it is allowed.
    parser_->body_limit(std::numeric_limits<uint64_t>::max());
    boost::beast::http::async_read_header(
        stream_, buffer_, *parser_,
        [self = this->shared_from_this()](Error error, size_t) { self->OnRead(error); });
  }

  void OnRead(Error error) {
    const RequestHead& head = parser_->get();
    if (error) {
      const auto answer = DescribeReadError(error, head, shared_.options.max_head_bytes);
      if (answer) Write(*answer, /*keep=*/false);
      return;
    }
    WebRequest request;
    request.host = peer_.host;
    if (const auto refusal = ReadRequest(head, shared_.options, request)) {
      return Write(*refusal, false);
    }
    if constexpr (kOpensWebSockets) {
      if (boost::beast::websocket::is_upgrade(head)) return Upgrade(request);
    }
    Ask(request);
  }

  void Upgrade(const WebRequest& request) {
    if (!IsOfSameSite(parser_->get())) {
      return Write(TextResponse(403, "a page of another site may not read this"), false);
    }
    absl::StatusOr<std::shared_ptr<const void>> page =
        shared_.pages.Enter(peer_.host, shared_.handler.CallerOf(request));
    if (!page.ok()) {
      return Write(
          TextResponse(503, absl::StrCat("too many pages are open: ", page.status().message())),
          false);
    }
    const auto socket =
        std::make_shared<WebSocket<Stream>>(std::move(stream_), parser_->release(), peer_,
                                            *std::move(page), this->shared_from_this(), shared_);
    socket_ = socket;
    socket->Accept(request);
  }

  void Ask(const WebRequest& request) {
    // However long the answer takes: who makes it has limits of its own, of how many at once, too.
    if (shared_.options.keeps_alive) Below().expires_never();
    use_.emplace(shared_, peer_.id);
    // What would follow on a connection behind a body is not known, since the body is not read.
    const bool keep = shared_.options.keeps_alive && parser_->keep_alive() && parser_->is_done();
    awaiting_ = this->shared_from_this();
    // The answer may come when the connection, and the server with it, has gone.
    Respond respond = [weak = this->weak_from_this(), poster = shared_.poster,
                       keep](WebResponse response) {
      poster->Post([weak, keep, response = std::move(response)] {
        if (const auto self = weak.lock()) self->WriteLater(response, keep);
      });
    };
    try {
      shared_.handler.Answer(request, std::move(respond));
    } catch (const std::exception& error) {
      LOG(ERROR) << "a web request ended with " << error.what();
      Write(TextResponse(500, "the answer could not be made"), false);
    }
  }

  void WriteLater(const WebResponse& answer, bool keep) {
    if (answer.delay <= absl::ZeroDuration()) return Write(answer, keep);
    // Nothing is under way meanwhile.
    use_.reset();
    holding_back_.emplace(stream_.get_executor(), absl::ToChronoNanoseconds(answer.delay));
    holding_back_->async_wait([weak = this->weak_from_this(), answer, keep](Error error) {
      const auto self = weak.lock();
      if (self != nullptr && !error) self->Write(answer, keep);
    });
  }

  void Write(const WebResponse& answer, bool keep) {
    namespace http = boost::beast::http;
    const std::shared_ptr<WebSession> kept = std::move(awaiting_);
    // A client that takes its answer slowly may make room for others.
    use_.reset();
    body_ = answer.body != nullptr ? answer.body : std::make_shared<const std::string>();
    response_ = {};
    response_.version(11);
    response_.result(static_cast<unsigned>(answer.status));
    response_.keep_alive(keep);
    response_.set(http::field::content_type, answer.content_type);
    for (const auto& [name, value] : answer.headers) response_.set(name, value);
    if (answer.status != 304) response_.content_length(body_->size());
    // The answer to HEAD has the length of what GET would bring.
    if (parser_->get().method() != http::verb::head)
      response_.body() = {body_->data(), body_->size()};
    RenewPatience();
    http::async_write(stream_, response_,
                      [self = this->shared_from_this(), keep](Error error, size_t) {
                        if (!error) self->OnWritten(keep);
                      });
  }

  void OnWritten(bool keep) {
    body_ = nullptr;
    if (keep) {
      RenewPatience();
      return Read();
    }
    Error ignored;
    Below().socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
    SetPatience(kDrainTime);
    Drain();
  }

  // Reads what still comes and forgets it: if the connection were closed at once, the system would
  // take back from the client what it has not read of the answer.
  void Drain() {
    buffer_.clear();
    Below().async_read_some(buffer_.prepare(kDrainedAtOnce),
                            [self = this->shared_from_this()](Error error, size_t) {
                              if (!error) self->Drain();
                            });
  }

  Stream stream_;
  const WebPeer peer_;
  WebShared& shared_;
  // From a request until its answer is made.
  std::optional<WebUse> use_;
  std::optional<boost::asio::steady_timer> holding_back_;
  boost::beast::flat_buffer buffer_{shared_.options.max_head_bytes};
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
  boost::beast::http::response<boost::beast::http::span_body<const char>> response_;
  std::shared_ptr<const std::string> body_;
  std::weak_ptr<WebConnection> socket_;
  // Keeps the connection while an answer is awaited.
  std::shared_ptr<WebSession> awaiting_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_HTTP_WEB_SESSION_H_
