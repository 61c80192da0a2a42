#include "services/http/testing/web_client.h"

#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <variant>

namespace corbslam::testing {
namespace {

namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using boost::asio::ip::tcp;
using Error = beast::error_code;

std::string PeerCertificate(SSL* session) {
  const std::unique_ptr<X509, decltype(&X509_free)> shown(SSL_get1_peer_certificate(session),
                                                          X509_free);
  const std::unique_ptr<BIO, decltype(&BIO_free)> text(BIO_new(BIO_s_mem()), BIO_free);
  if (shown == nullptr || PEM_write_bio_X509(text.get(), shown.get()) != 1) return "";
  char* begin = nullptr;
  const long size = BIO_get_mem_data(text.get(), &begin);
  return {begin, static_cast<size_t>(size)};
}

}  // namespace

class WebSocketClient::Impl {
 public:
  Impl(const std::string& address, const std::string& target, const SocketOptions& options) {
    if (options.tls) {
      auto& socket = socket_.emplace<Tls>(context_, tls_);
      Connect(socket, address);
      Error error;
      socket.next_layer().handshake(boost::asio::ssl::stream_base::client, error);
      if (error) return;
      certificate = PeerCertificate(socket.next_layer().native_handle());
      Handshake(socket, address, target, options);
    } else {
      auto& socket = socket_.emplace<Plain>(context_);
      Connect(socket, address);
      Handshake(socket, address, target, options);
    }
  }

  std::optional<std::string> Read(absl::Duration patience) {
    if (auto* socket = std::get_if<Plain>(&socket_)) return ReadFrom(*socket, patience);
    if (auto* socket = std::get_if<Tls>(&socket_)) return ReadFrom(*socket, patience);
    return std::nullopt;
  }

  bool Send(const std::string& text) {
    Error error;
    if (auto* socket = std::get_if<Plain>(&socket_)) {
      socket->write(boost::asio::buffer(text), error);
    }
    return !error;
  }

  bool stands = false;
  std::string protocol;
  uint16_t close_code = 0;
  std::string certificate;

 private:
  using Plain = websocket::stream<beast::tcp_stream>;
  using Tls = websocket::stream<beast::ssl_stream<beast::tcp_stream>>;

  template <typename Socket>
  void Connect(Socket& socket, const std::string& address) {
    const size_t colon = address.rfind(':');
    Error error;
    beast::get_lowest_layer(socket).socket().connect(
        tcp::endpoint(boost::asio::ip::make_address(address.substr(0, colon)),
                      static_cast<uint16_t>(std::stoi(address.substr(colon + 1)))),
        error);
  }

  template <typename Socket>
  void Handshake(Socket& socket, const std::string& host, const std::string& target,
                 const SocketOptions& options) {
    socket.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
      if (!options.origin.empty()) request.set(beast::http::field::origin, options.origin);
      request.set(beast::http::field::sec_websocket_protocol, options.protocols);
    }));
    socket.read_message_max(64u << 20);
    websocket::response_type response;
    Error error;
    socket.handshake(response, host, target, error);
    if (error) return;
    stands = true;
    const auto chosen = response[beast::http::field::sec_websocket_protocol];
    protocol = std::string(chosen.data(), chosen.size());
  }

  template <typename Socket>
  std::optional<std::string> ReadFrom(Socket& socket, absl::Duration patience) {
    beast::flat_buffer buffer;
    std::optional<Error> ended;
    socket.async_read(buffer, [&ended](Error error, size_t) { ended = error; });
    context_.restart();
    context_.run_for(absl::ToChronoMilliseconds(patience));
    if (!ended) {
      beast::get_lowest_layer(socket).close();
      context_.restart();
      context_.run();
      return std::nullopt;
    }
    if (*ended == websocket::error::closed) close_code = socket.reason().code;
    if (*ended) return std::nullopt;
    return beast::buffers_to_string(buffer.data());
  }

  boost::asio::io_context context_;
  boost::asio::ssl::context tls_{boost::asio::ssl::context::tls_client};
  std::variant<std::monostate, Plain, Tls> socket_;
};

WebSocketClient::WebSocketClient(const std::string& address, const std::string& target,
                                 const SocketOptions& options)
    : impl_(std::make_unique<Impl>(address, target, options)) {}
WebSocketClient::~WebSocketClient() = default;
bool WebSocketClient::stands() const { return impl_->stands; }
std::string WebSocketClient::protocol() const { return impl_->protocol; }
std::optional<std::string> WebSocketClient::Read(absl::Duration patience) {
  return impl_->Read(patience);
}
uint16_t WebSocketClient::close_code() const { return impl_->close_code; }
std::string WebSocketClient::certificate() const { return impl_->certificate; }
bool WebSocketClient::Send(const std::string& text) { return impl_->Send(text); }

}  // namespace corbslam::testing
