// Sends one browser a stream over its WebSocket.
#ifndef CORBSLAM_SERVICES_HTTP_WEB_SOCKET_H_
#define CORBSLAM_SERVICES_HTTP_WEB_SOCKET_H_

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/stream_traits.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "services/http/web_connection.h"
#include "services/http/web_target.h"

namespace corbslam::services {

// The name of what the page and its server speak with each other.
inline constexpr char kWebSocketProtocol[] = "corbslam";

// Sends one message after the other, each once the one before it has gone out. `Stream` is the
// stream below. Only the server's thread uses it.
template <typename Stream>
class WebSocket : public WebConnection, public std::enable_shared_from_this<WebSocket<Stream>> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  // `page` counts as an open page as long as a stream stands; by `session` the server knows the
  // connection, which it stays as long as this lives.
  WebSocket(Stream stream, Request request, WebPeer peer, std::shared_ptr<const void> page,
            std::shared_ptr<const void> session, WebShared& shared)
      : socket_(std::move(stream)),
        request_(std::move(request)),
        peer_(std::move(peer)),
        shared_(shared),
        page_(std::move(page)),
        session_(std::move(session)),
        timer_(socket_.get_executor()) {}
  ~WebSocket() override { Release(); }

  // Tells the browser that the stream stands, then sends what the handler opens for `request`.
  void Accept(const WebRequest& request) {
    opened_ = shared_.handler.Open(request, Waker());
    if (opened_.stream == nullptr) {
      // Who is refused takes no page from others, however slowly it hears of it.
      page_ = nullptr;
    } else {
      use_.emplace(shared_, peer_.id);
      ++shared_.streams;
    }
    SetTimeouts();
    SetProtocol();
    socket_.read_message_max(kMaxReadBytes);
    socket_.binary(true);
    socket_.async_accept(request_, [self = this->shared_from_this()](Error error) {
      if (!error) self->OnAccepted();
    });
  }
  void Start() override {}
  void Close() override {
    Release();
    timer_.cancel();
    boost::beast::get_lowest_layer(socket_).close();
  }

 private:
  using Error = boost::beast::error_code;
  using Settings = boost::beast::websocket::stream_base;

  // Longest time for a browser to hear that its socket is closed.
  static constexpr auto kCloseTime = std::chrono::seconds(2);
  // The page sends nothing.
  static constexpr size_t kMaxReadBytes = 1024;

  void SetTimeouts() {
    const auto patience = absl::ToChronoSeconds(shared_.options.patience);
    boost::beast::get_lowest_layer(socket_).expires_never();
    Settings::timeout timeout = Settings::timeout::suggested(boost::beast::role_type::server);
    timeout.handshake_timeout = patience;
    timeout.idle_timeout = patience;
    timeout.keep_alive_pings = true;
    socket_.set_option(timeout);
  }

  void SetProtocol() {
    const auto protocols = request_[boost::beast::http::field::sec_websocket_protocol];
    if (!OffersProtocol({protocols.data(), protocols.size()}, kWebSocketProtocol)) return;
    socket_.set_option(Settings::decorator([](boost::beast::websocket::response_type& response) {
      response.set(boost::beast::http::field::sec_websocket_protocol, kWebSocketProtocol);
    }));
  }

  // The function may be called from any thread, also when the socket is gone.
  std::function<void()> Waker() {
    return [weak = this->weak_from_this(), poster = shared_.poster] {
      poster->Post([weak] {
        if (const auto self = weak.lock()) self->Send();
      });
    };
  }

  void OnAccepted() {
    accepted_ = true;
    if (opened_.stream == nullptr) {
      if (opened_.delay <= absl::ZeroDuration()) return End(opened_.close_code, opened_.reason);
      return After(absl::ToChronoNanoseconds(opened_.delay),
                   [this] { End(opened_.close_code, opened_.reason); });
    }
    Read();
    Send();
    AskWhetherItMayStay();
  }

  template <typename Duration, typename Then>
  void After(Duration duration, Then then) {
    timer_.expires_after(duration);
    timer_.async_wait([self = this->shared_from_this(), then](Error error) {
      if (!error) then();
    });
  }

  void AskWhetherItMayStay() {
    After(absl::ToChronoNanoseconds(shared_.options.stay_interval), [this] {
      if (opened_.stream == nullptr) return;
      const CloseReason why = opened_.stream->WhyClose();
      if (why.code == 0) return AskWhetherItMayStay();
      Release();
      End(why.code, why.text);
    });
  }

  // Sends nothing more, and counts no more.
  void Release() {
    page_ = nullptr;
    use_.reset();
    if (opened_.stream == nullptr) return;
    opened_.stream.reset();
    --shared_.streams;
  }

  // Hears of the browser's end, and passes over what it says.
  void Read() {
    socket_.async_read(read_, [self = this->shared_from_this()](Error error, size_t) {
      if (error) return self->OnGone();
      self->read_.clear();
      self->Read();
    });
  }

  void OnGone() {
    Release();
    timer_.cancel();
  }

  void Send() {
    if (!accepted_ || sending_ != nullptr || opened_.stream == nullptr) return;
    sending_ = opened_.stream->Next();
    if (sending_ == nullptr) return;
    socket_.async_write(boost::asio::buffer(*sending_),
                        [self = this->shared_from_this()](Error error, size_t) {
                          self->sending_ = nullptr;
                          if (error) return self->Close();
                          self->Send();
                        });
  }

  void End(uint16_t code, const std::string& reason) {
    boost::beast::websocket::close_reason why(code);
    why.reason = reason.substr(0, why.reason.max_size());
    // A browser that takes nothing, or does not answer, is not waited for.
    After(kCloseTime, [this] { boost::beast::get_lowest_layer(socket_).close(); });
    socket_.async_close(why, [self = this->shared_from_this()](Error) { self->timer_.cancel(); });
  }

  boost::beast::websocket::stream<Stream> socket_;
  const Request request_;
  const WebPeer peer_;
  WebShared& shared_;
  std::shared_ptr<const void> page_;
  const std::shared_ptr<const void> session_;
  std::optional<WebUse> use_;
  boost::asio::steady_timer timer_;
  OpenedStream opened_;
  bool accepted_ = false;
  boost::beast::flat_buffer read_;
  std::shared_ptr<const std::string> sending_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_HTTP_WEB_SOCKET_H_
