#include "services/runtime/address.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr int kLargestPort = 65535;

template <typename... Parts>
absl::Status Wrong(absl::string_view address, const Parts&... parts) {
  return absl::InvalidArgumentError(absl::StrCat("address is \"", address, "\": it ", parts...));
}

bool IsIpv6(absl::string_view host) {
  in6_addr parsed;
  // What stands behind % is the interface of a link-local address.
  return inet_pton(AF_INET6, std::string(host.substr(0, host.find('%'))).c_str(), &parsed) == 1;
}

// Returns the address without one of gRPC's schemes in front, which change nothing.
absl::string_view StripKnownScheme(absl::string_view address) {
  constexpr std::array<absl::string_view, 4> kSchemes = {"dns:///", "dns:", "ipv4:", "ipv6:"};
  for (const absl::string_view scheme : kSchemes) {
    // A host may have such a name: "dns:50051".
    absl::string_view rest = address;
    if (!absl::ConsumePrefix(&rest, scheme)) continue;
    const bool has_authority = absl::StartsWith(rest, "//");
    if (absl::StrContains(scheme, '/') || (absl::StrContains(rest, ':') && !has_authority)) {
      return rest;
    }
  }
  return address;
}

absl::Status CheckCharacters(absl::string_view address) {
  if (address.empty()) {
    return Wrong(address, "is empty; give HOST:PORT, as store.lan:50051");
  }
  if (std::any_of(address.begin(), address.end(), absl::ascii_isspace)) {
    return Wrong(address, "has a blank in it; give HOST:PORT alone");
  }
  if (absl::StrContains(address, ',')) {
    return Wrong(address, "has a comma in it; give one HOST:PORT");
  }
  const size_t scheme = address.find("://");
  if (scheme != absl::string_view::npos) {
    const absl::string_view rest = address.substr(scheme + 3);
    const absl::string_view host = rest.substr(0, rest.find('/'));
    return Wrong(address, "begins with ", address.substr(0, scheme + 3),
                 ", and no scheme belongs there; give ", host,
                 absl::StrContains(host, ':') ? "" : ":PORT");
  }
  if (absl::StartsWith(address, "unix:") || absl::StartsWith(address, "unix-abstract:")) {
    return Wrong(address, "is a Unix socket's, and CORB-SLAM uses TCP only; give HOST:PORT");
  }
  return absl::OkStatus();
}

// Refuses a bare IPv6 address: where it ends and the port begins can't be told.
absl::Status NeedsBrackets(absl::string_view address) {
  const size_t colon = address.rfind(':');
  const absl::string_view before = address.substr(0, colon);
  const std::string meant = IsIpv6(before) ? absl::StrCat("[", before, "]", address.substr(colon))
                                           : absl::StrCat("[", address, "]:PORT");
  return Wrong(address, "is an IPv6 address without brackets; give ", meant);
}

absl::StatusOr<int> ParsePort(absl::string_view address, absl::string_view text, int smallest) {
  int port = 0;
  const bool is_number =
      !text.empty() && std::all_of(text.begin(), text.end(), absl::ascii_isdigit);
  if (is_number && absl::SimpleAtoi(text, &port) && port >= smallest && port <= kLargestPort) {
    return port;
  }
  if (is_number && port == 0 && absl::SimpleAtoi(text, &port)) {
    return Wrong(address,
                 "has port 0, by which a server's --listen lets the system choose one; give the "
                 "port that the server says it is \"listening on\"");
  }
  const size_t slash = text.find('/');
  if (slash != absl::string_view::npos) {
    return Wrong(address, "has \"", text.substr(slash), "\" behind the port; give HOST:PORT alone");
  }
  if (text.empty()) return Wrong(address, "has no port behind its colon; give HOST:PORT");
  return Wrong(address, "has port \"", text, "\", must be a number of ", smallest, " to ",
               kLargestPort);
}

// Splits the address into the host, with its brackets, and the port.
absl::StatusOr<HostPort> Split(absl::string_view whole, absl::string_view address,
                               int smallest_port) {
  if (IsIpv6(address)) return NeedsBrackets(address);
  const size_t colon = address.rfind(':');
  const size_t bracket = address.rfind(']');
  const bool has_port =
      colon != absl::string_view::npos && (bracket == absl::string_view::npos || colon > bracket);
  if (!has_port) {
    return Wrong(whole, "has no port; give HOST:PORT, as ", address, ":50051");
  }
  absl::string_view host = address.substr(0, colon);
  if (absl::StartsWith(host, "[") && absl::EndsWith(host, "]")) {
    host = host.substr(1, host.size() - 2);
    if (!IsIpv6(host)) return Wrong(whole, "has no IPv6 address between its brackets");
  } else if (host.find_first_of("[]") != absl::string_view::npos) {
    return Wrong(whole, "has a bracket without its other; give HOST:PORT or [IPV6]:PORT");
  } else if (absl::StrContains(host, ':')) {
    if (IsIpv6(host)) return NeedsBrackets(address);
    return Wrong(whole, "has more than one colon; give HOST:PORT");
  }
  ASSIGN_OR_RETURN(const int port, ParsePort(whole, address.substr(colon + 1), smallest_port));
  return HostPort{std::string(host), port};
}

absl::StatusOr<HostPort> Parse(absl::string_view address, int smallest_port) {
  const absl::string_view rest = StripKnownScheme(address);
  RETURN_IF_ERROR(CheckCharacters(rest));
  return Split(address, rest, smallest_port);
}

}  // namespace

absl::StatusOr<HostPort> ParseListenAddress(absl::string_view address) { return Parse(address, 0); }

absl::StatusOr<HostPort> ParseServerAddress(absl::string_view address) {
  ASSIGN_OR_RETURN(HostPort parsed, Parse(address, 1));
  if (!parsed.host.empty()) return parsed;
  return Wrong(address, "has no host; give HOST:PORT, for this machine 127.0.0.1:", parsed.port);
}

std::string ToString(const HostPort& address) {
  const bool is_ipv6 = absl::StrContains(address.host, ':');
  return absl::StrCat(is_ipv6 ? "[" : "", address.host, is_ipv6 ? "]" : "", ":", address.port);
}

}  // namespace corbslam::services
