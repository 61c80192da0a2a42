// Holds what an HTTP request asks and what is answered, without the library that reads and writes
// them.
#ifndef CORBSLAM_SERVICES_HTTP_HTTP_MESSAGE_H_
#define CORBSLAM_SERVICES_HTTP_HTTP_MESSAGE_H_

#include <functional>
#include <string>

namespace corbslam::services {

// Holds a request's first line. Its headers count for nothing, and its body is not read.
struct HttpRequest {
  std::string method;  // The word that was sent: "GET", or any other.
  std::string path;    // Without host, query and fragment; otherwise as it was sent.
};

struct HttpResponse {
  int status = 200;
  std::string content_type = "text/plain; charset=utf-8";
  std::string body = {};
  std::string allow = {};  // The methods that a resource has; set for status 405 only.
};

// Called on the server's one thread. If it throws, the answer is 500.
using HttpHandler = std::function<HttpResponse(const HttpRequest&)>;

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_HTTP_HTTP_MESSAGE_H_
