// Makes a web server serve browsers: WebSockets, and TLS.
#ifndef CORBSLAM_SERVICES_HTTP_BROWSER_OPTIONS_H_
#define CORBSLAM_SERVICES_HTTP_BROWSER_OPTIONS_H_

#include <memory>

#include "services/http/web_server.h"
#include "services/http/web_tls.h"

namespace corbslam::services {

// Connections go by the key pair that `tls` has when they come; null: no TLS.
WebServerOptions BrowserOptions(std::shared_ptr<const WebTls> tls = nullptr);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_HTTP_BROWSER_OPTIONS_H_
