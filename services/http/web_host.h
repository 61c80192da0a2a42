// Knows by which names browsers may call a server.
#ifndef CORBSLAM_SERVICES_HTTP_WEB_HOST_H_
#define CORBSLAM_SERVICES_HTTP_WEB_HOST_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace corbslam::services {

// Stands for every name.
inline constexpr char kEveryHost[] = "*";

// Returns true if a request's Host, "name:port", is this server: an IP address, "localhost" or a
// name under it, one of `names`, or none at all, which no browser sends. Any other name may be a
// strange site's whose name leads here (DNS rebinding): for a browser, that site's pages and this
// server were one origin.
bool IsOwnHost(absl::string_view host, const std::vector<std::string>& names);

// INVALID_ARGUMENT, with `what` in front, for what no Host can be: it must be a name without scheme
// and port, or "*".
absl::Status CheckHostName(absl::string_view what, absl::string_view name);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_HTTP_WEB_HOST_H_
