// Finds the HTTP proxy that gRPC goes through because the environment says so.
#ifndef CORBSLAM_SERVICES_CLIENT_REACHABILITY_PROXY_H_
#define CORBSLAM_SERVICES_CLIENT_REACHABILITY_PROXY_H_

#include <functional>
#include <optional>
#include <string>

#include "services/runtime/address.h"

namespace corbslam::services {

struct Proxy {
  std::string variable;  // For example "http_proxy".
  std::string url;       // The URL as it is set, without a password.
  // Address of the proxy; nullopt if the URL does not tell it.
  std::optional<HostPort> address;
};

// Returns the value of an environment variable; null if it is not set.
using ReadVariable = std::function<const char*(const char*)>;

// Returns the proxy for `host`; nullopt if gRPC goes there straight. gRPC looks at grpc_proxy,
// https_proxy and http_proxy, in this order and in small letters only, and goes straight to hosts
// that no_grpc_proxy, or else no_proxy, names; loopback addresses are no exception. (gRPC 1.51,
// src/core/ext/filters/client_channel/http_proxy.cc.)
std::optional<Proxy> FindProxy(const std::string& host, const ReadVariable& read);
std::optional<Proxy> FindProxy(const std::string& host);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_REACHABILITY_PROXY_H_
