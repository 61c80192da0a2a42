// Reads what stands in a request's head.
#ifndef CORBSLAM_SERVICES_HTTP_WEB_TARGET_H_
#define CORBSLAM_SERVICES_HTTP_WEB_TARGET_H_

#include <optional>
#include <string>

#include "absl/strings/string_view.h"
#include "services/http/web_message.h"

namespace corbslam::services {

// Decodes "%41" and, in a query, "+". Nullopt: a percent sign without two hexadecimal digits, or a
// zero byte.
std::optional<std::string> DecodePercent(absl::string_view text, bool plus_is_space);

// Sets the path and the query of a request from its target: "/path?name=value",
// "http://host/path?name=value" as a proxy would send it, or "*". Returns false if it can't be
// read.
bool ReadTarget(absl::string_view target, WebRequest& request);

// Returns what follows "token." in a list of WebSocket protocols, "corbslam, token.abc"; empty:
// none.
std::string TokenOfProtocols(absl::string_view protocols);
bool OffersProtocol(absl::string_view protocols, absl::string_view protocol);

// Returns true if a page of `origin` ("https://host:port") came from the server that its request
// calls `host`. No origin: no browser's page asks.
bool IsSameOrigin(absl::string_view origin, absl::string_view host);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_HTTP_WEB_TARGET_H_
