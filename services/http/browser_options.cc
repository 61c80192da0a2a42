#include "services/http/browser_options.h"

#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <utility>

#include "services/http/web_session.h"

namespace corbslam::services {
namespace {

using TlsStream = boost::beast::ssl_stream<TcpStream>;

class BrowserConnector : public WebConnector {
 public:
  explicit BrowserConnector(std::shared_ptr<const WebTls> tls) : tls_(std::move(tls)) {}

  std::shared_ptr<WebConnection> Connect(boost::asio::ip::tcp::socket socket, WebPeer peer,
                                         WebShared& shared) const override {
    TcpStream stream(std::move(socket));
    if (tls_ == nullptr) return Session(std::move(stream), std::move(peer), shared);
    // The stream's session holds what it needs of the context.
    const auto context = tls_->context();
    return Session(TlsStream(std::move(stream), *context), std::move(peer), shared);
  }

 private:
  template <typename Stream>
  static std::shared_ptr<WebConnection> Session(Stream stream, WebPeer peer, WebShared& shared) {
    return std::make_shared<WebSession<Stream, true>>(std::move(stream), std::move(peer), shared);
  }

  const std::shared_ptr<const WebTls> tls_;
};

}  // namespace

WebServerOptions BrowserOptions(std::shared_ptr<const WebTls> tls) {
  return {.connector = std::make_shared<BrowserConnector>(std::move(tls)),
          .connections = {.all = 1024, .of_host = 512},
          .max_head_bytes = 16 << 10,
          .keeps_alive = true,
          .steps_behind = false,
          .max_streams = 100};
}

}  // namespace corbslam::services
