#include "services/viewer/web/web_connection.h"

#include <glog/logging.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/span_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <exception>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "services/viewer/web/web_host.h"
#include "services/viewer/web/web_socket.h"
#include "services/viewer/web/web_target.h"

namespace corbslam::services {
namespace {

namespace beast = boost::beast;
namespace http = boost::beast::http;
using Error = beast::error_code;
using Tcp = beast::tcp_stream;
using Tls = beast::ssl_stream<beast::tcp_stream>;
using Request = http::request<http::empty_body>;

constexpr size_t kMaxHeadBytes = 16 << 10;

std::string Text(beast::string_view text) { return std::string(text.data(), text.size()); }

// Returns false if the request's target can't be read.
bool ReadRequest(const Request& head, WebRequest& request) {
  request.method = Text(head.method_string());
  request.authorization = Text(head[http::field::authorization]);
  request.token = TokenOfProtocols(Text(head[http::field::sec_websocket_protocol]));
  request.if_none_match = Text(head[http::field::if_none_match]);
  request.takes_gzip = absl::StrContains(Text(head[http::field::accept_encoding]), "gzip");
  return ReadTarget(Text(head.target()), request);
}

WebResponse Refuse(int status, absl::string_view why) {
  WebResponse response;
  response.status = status;
  response.body = std::make_shared<const std::string>(absl::StrCat(why, "\n"));
  return response;
}

WebResponse RefuseHost(absl::string_view host) {
  WebResponse response = Refuse(
      421, absl::StrCat("this server does not go by the name \"", absl::CHexEscape(host),
                        "\": use its IP address, or start it with --web-host and that name"));
  response.headers["X-Content-Type-Options"] = "nosniff";
  return response;
}

// Returns the answer to what can't be read as a request; nullopt: nobody listens.
std::optional<WebResponse> DescribeReadError(Error error) {
  if (error.category() != make_error_code(http::error::bad_method).category() ||
      error == http::error::end_of_stream || error == http::error::partial_message) {
    return std::nullopt;
  }
  if (error == http::error::header_limit || error == http::error::buffer_overflow) {
    return Refuse(431, absl::StrCat("the request's head has over ", kMaxHeadBytes, " bytes"));
  }
  if (error == http::error::body_limit || error == http::error::unexpected_body) {
    return Refuse(413, "requests have no body here");
  }
  return Refuse(400, absl::StrCat("this is no HTTP/1.1: ", error.message()));
}

// Reads requests and writes answers, until a WebSocket takes over.
template <typename Stream>
class HttpSession : public WebConnection, public std::enable_shared_from_this<HttpSession<Stream>> {
 public:
  HttpSession(Stream stream, WebPeer peer, WebShared& shared)
      : stream_(std::move(stream)), peer_(std::move(peer)), shared_(shared) {}

  void Start() override {
    SetPatience(shared_.options.first_patience);
    if constexpr (std::is_same_v<Stream, Tls>) {
      stream_.async_handshake(boost::asio::ssl::stream_base::server,
                              [self = this->shared_from_this()](Error error) {
                                if (!error) self->Read(self->shared_.options.first_patience);
                              });
    } else {
      Read(shared_.options.first_patience);
    }
  }
  void Close() override {
    // It may be all that keeps this.
    const std::shared_ptr<HttpSession> kept = std::move(awaiting_);
    use_.reset();
    holding_back_.reset();
    if (const auto socket = socket_.lock()) return socket->Close();
    beast::get_lowest_layer(stream_).close();
  }

 private:
  void SetPatience(absl::Duration patience) {
    beast::get_lowest_layer(stream_).expires_after(
        absl::ToChronoNanoseconds(std::min(patience, shared_.options.patience)));
  }

  void Read(absl::Duration patience) {
    parser_.emplace();
    parser_->header_limit(kMaxHeadBytes);
    parser_->body_limit(0);
    SetPatience(patience);
    http::async_read(
        stream_, buffer_, *parser_,
        [self = this->shared_from_this()](Error error, size_t) { self->OnRead(error); });
  }

  void OnRead(Error error) {
    if (error) {
      const std::optional<WebResponse> answer = DescribeReadError(error);
      if (answer) Write(*answer, /*keep=*/false);
      return;
    }
    WebRequest request;
    request.host = peer_.host;
    if (!ReadRequest(parser_->get(), request)) {
      return Write(Refuse(400, "the path or query can't be read"), false);
    }
    if (const std::string host = Text(parser_->get()[http::field::host]); !IsOwn(host)) {
      return Write(RefuseHost(host), false);
    }
    if (beast::websocket::is_upgrade(parser_->get())) return Upgrade(request);
    Ask(request);
  }

  bool IsOwn(absl::string_view host) const {
    return !shared_.options.hosts || IsOwnHost(host, *shared_.options.hosts);
  }

  void Upgrade(const WebRequest& request) {
    const Request& head = parser_->get();
    if (!IsSameOrigin(Text(head[http::field::origin]), Text(head[http::field::host]))) {
      return Write(Refuse(403, "a page of another site may not read this"), false);
    }
    absl::StatusOr<std::shared_ptr<const void>> page =
        shared_.pages.Enter(peer_.host, shared_.handler.CallerOf(request));
    if (!page.ok()) {
      return Write(Refuse(503, absl::StrCat("too many pages are open: ", page.status().message())),
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
    beast::get_lowest_layer(stream_).expires_never();
    use_.emplace(shared_, peer_.id);
    const bool keep = parser_->get().keep_alive();
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
      Write(Refuse(500, "the answer could not be made"), false);
    }
  }

  void WriteLater(const WebResponse& answer, bool keep) {
    if (answer.held_back <= absl::ZeroDuration()) return Write(answer, keep);
    // Nothing is under way meanwhile.
    use_.reset();
    holding_back_.emplace(stream_.get_executor(), absl::ToChronoNanoseconds(answer.held_back));
    holding_back_->async_wait([weak = this->weak_from_this(), answer, keep](Error error) {
      const auto self = weak.lock();
      if (self != nullptr && !error) self->Write(answer, keep);
    });
  }

  void Write(const WebResponse& answer, bool keep) {
    const std::shared_ptr<HttpSession> kept = std::move(awaiting_);
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
    SetPatience(shared_.options.patience);
    http::async_write(stream_, response_,
                      [self = this->shared_from_this(), keep](Error error, size_t) {
                        if (!error) self->OnWritten(keep);
                      });
  }

  void OnWritten(bool keep) {
    body_ = nullptr;
    if (keep) return Read(shared_.options.patience);
    Error error;
    beast::get_lowest_layer(stream_).socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send,
                                                       error);
  }

  Stream stream_;
  const WebPeer peer_;
  WebShared& shared_;
  // From a request until its answer is made.
  std::optional<WebUse> use_;
  std::optional<boost::asio::steady_timer> holding_back_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::empty_body>> parser_;
  http::response<http::span_body<const char>> response_;
  std::shared_ptr<const std::string> body_;
  std::weak_ptr<WebConnection> socket_;
  // Keeps the connection while an answer is awaited.
  std::shared_ptr<HttpSession> awaiting_;
};

}  // namespace

void LoopPoster::Post(std::function<void()> function) {
  absl::MutexLock lock(&mutex_);
  if (context_ != nullptr) boost::asio::post(*context_, std::move(function));
}

void LoopPoster::End() {
  absl::MutexLock lock(&mutex_);
  context_ = nullptr;
}

std::shared_ptr<WebConnection> MakeWebConnection(boost::asio::ip::tcp::socket socket, WebPeer peer,
                                                 WebShared& shared) {
  Tcp stream(std::move(socket));
  if (shared.options.tls == nullptr) {
    return std::make_shared<HttpSession<Tcp>>(std::move(stream), std::move(peer), shared);
  }
  // The stream's session holds what it needs of the context.
  const auto context = shared.options.tls->context();
  return std::make_shared<HttpSession<Tls>>(Tls(std::move(stream), *context), std::move(peer),
                                            shared);
}

}  // namespace corbslam::services
