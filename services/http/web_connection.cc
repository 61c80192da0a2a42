#include "services/http/web_connection.h"

#include <boost/asio/post.hpp>
#include <boost/beast/http/error.hpp>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "services/http/web_host.h"
#include "services/http/web_session.h"
#include "services/http/web_target.h"

namespace corbslam::services {
namespace {

namespace http = boost::beast::http;

std::string Text(boost::beast::string_view text) { return std::string(text.data(), text.size()); }

WebResponse RefuseHost(absl::string_view host) {
  WebResponse response = TextResponse(
      421, absl::StrCat("this server does not go by the name \"", absl::CHexEscape(host),
                        "\": use its IP address, or start it with --web-host and that name"));
  response.headers["X-Content-Type-Options"] = "nosniff";
  return response;
}

class Plain : public WebConnector {
 public:
  std::shared_ptr<WebConnection> Connect(boost::asio::ip::tcp::socket socket, WebPeer peer,
                                         WebShared& shared) const override {
    return std::make_shared<WebSession<TcpStream, false>>(TcpStream(std::move(socket)),
                                                          std::move(peer), shared);
  }
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

WebResponse TextResponse(int status, absl::string_view text) {
  return {.status = status, .body = std::make_shared<const std::string>(absl::StrCat(text, "\n"))};
}

std::optional<WebResponse> ReadRequest(const RequestHead& head, const WebServerOptions& options,
                                       WebRequest& request) {
  request.method = Text(head.method_string());
  request.authorization = Text(head[http::field::authorization]);
  request.token = TokenOfProtocols(Text(head[http::field::sec_websocket_protocol]));
  request.if_none_match = Text(head[http::field::if_none_match]);
  request.takes_gzip = absl::StrContains(Text(head[http::field::accept_encoding]), "gzip");
  if (!ReadTarget(Text(head.target()), request)) {
    return TextResponse(400, "the path or query can't be read");
  }
  const std::string host = Text(head[http::field::host]);
  if (options.hosts && !IsOwnHost(host, *options.hosts)) return RefuseHost(host);
  return std::nullopt;
}

std::optional<WebResponse> DescribeReadError(boost::beast::error_code error,
                                             const RequestHead& head, size_t max_head_bytes) {
  if (error.category() != make_error_code(http::error::bad_method).category() ||
      error == http::error::end_of_stream || error == http::error::partial_message) {
    return std::nullopt;
  }
  if (error != http::error::header_limit && error != http::error::buffer_overflow) {
    return TextResponse(400, absl::StrCat("this is no HTTP/1.1: ", error.message()));
  }
  // The parser takes the first line only as a whole, so that a long one leaves no target.
  if (head.target().empty()) {
    return TextResponse(414, absl::StrCat("the first line has over ", max_head_bytes, " bytes"));
  }
  return TextResponse(431, absl::StrCat("the headers have over ", max_head_bytes, " bytes"));
}

bool IsOfSameSite(const RequestHead& head) {
  return IsSameOrigin(Text(head[http::field::origin]), Text(head[http::field::host]));
}

std::shared_ptr<const WebConnector> PlainConnector() { return std::make_shared<Plain>(); }

}  // namespace corbslam::services
