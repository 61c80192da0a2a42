// Holds what clients ask and are answered, without the library that reads and writes it.
#ifndef CORBSLAM_SERVICES_HTTP_WEB_MESSAGE_H_
#define CORBSLAM_SERVICES_HTTP_WEB_MESSAGE_H_

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"

namespace corbslam::services {

struct WebRequest {
  std::string host;                          // Whose connection it is (HostOfIp).
  std::string method;                        // The word that was sent: "GET", or any other.
  std::string path;                          // Without query; percent signs are decoded.
  std::map<std::string, std::string> query;  // Decoded; of a name that comes twice the last value.
  std::string authorization;                 // Empty: none.
  std::string token;                         // Of a WebSocket's protocols: what "token." precedes.
  std::string if_none_match;
  bool takes_gzip = false;
};

struct WebResponse {
  int status = 200;
  std::string content_type = "text/plain; charset=utf-8";
  std::shared_ptr<const std::string> body = nullptr;  // Null: empty.
  std::map<std::string, std::string> headers = {};    // Further ones.
  // The answer is held back for so long; the connection may make room for others meanwhile.
  absl::Duration delay = absl::ZeroDuration();
};

// Returns an answer of one line of text.
WebResponse TextResponse(int status, absl::string_view text);

// Takes the answer to a request, once; from any thread.
using Respond = std::function<void(WebResponse)>;

// A close code of WebSocket's (4000 to 4999) and its reason as text; 0: none.
struct CloseReason {
  uint16_t code = 0;
  std::string text;
};

// What one WebSocket is sent. Its functions are called on the server's thread.
class WebStream {
 public:
  virtual ~WebStream() = default;
  // Returns the next message; null: there is none now, and `wake` will be called when there may be.
  virtual std::shared_ptr<const std::string> Next() = 0;
  // Returns why it may not stay open; asked again and again.
  virtual CloseReason WhyClose() { return {}; }
};

// A stream, or why there is none.
struct OpenedStream {
  std::unique_ptr<WebStream> stream;
  uint16_t close_code = 0;
  std::string reason;
  // The refusal is held back for so long.
  absl::Duration delay = absl::ZeroDuration();
};

class WebHandler {
 public:
  virtual ~WebHandler() = default;
  // All are called on the server's thread and must return soon. What Answer throws is a 500.
  virtual void Answer(const WebRequest& request, Respond respond) = 0;
  // Returns a name of who asks, for people; empty: nobody knows. Of one name a quarter of the
  // streams may be.
  virtual std::string CallerOf(const WebRequest& request) {
    (void)request;
    return "";
  }
  // `wake` may be called from any thread, also after the stream is gone. As it is: never called,
  // since there are no WebSockets without BrowserOptions (browser_options.h).
  virtual OpenedStream Open(const WebRequest& request, std::function<void()> wake) {
    (void)request, (void)wake;
    return {};
  }
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_HTTP_WEB_MESSAGE_H_
