// What an HTTP request asks and what is answered, without the library that reads and writes them.
#ifndef CORBSLAM_SERVICES_HTTP_HTTP_MESSAGE_H_
#define CORBSLAM_SERVICES_HTTP_HTTP_MESSAGE_H_

#include <functional>
#include <string>

namespace corbslam {

// A request's first line. Its headers count for nothing, and its body is not read.
struct HttpRequest {
  std::string method;  // As it was sent: "GET", or any other word.
  std::string path;    // Without host, query and fragment; as it was sent otherwise.
};

struct HttpResponse {
  int status = 200;
  std::string content_type = "text/plain; charset=utf-8";
  std::string body = {};
  std::string allow = {};  // The methods that a resource has; for status 405 only.
};

// Called on the server's one thread. What it throws is answered with 500.
using HttpHandler = std::function<HttpResponse(const HttpRequest&)>;

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_HTTP_HTTP_MESSAGE_H_
