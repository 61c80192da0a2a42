#include "services/http/web_host.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <optional>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace corbslam::services {
namespace {

constexpr size_t kLongestName = 253;

bool IsAddress(int family, absl::string_view text) {
  in6_addr parsed = {};
  return inet_pton(family, std::string(text).c_str(), &parsed) == 1;
}

bool IsPort(absl::string_view text) {
  return text.empty() || (absl::ConsumePrefix(&text, ":") && text.size() <= 5 &&
                          std::all_of(text.begin(), text.end(), absl::ascii_isdigit));
}

// Returns the part before the port, without an IPv6 address's brackets; nullopt: it is no host.
std::optional<absl::string_view> WithoutPort(absl::string_view host) {
  if (absl::ConsumePrefix(&host, "[")) {
    const size_t end = host.find(']');
    if (end == absl::string_view::npos || !IsPort(host.substr(end + 1))) return std::nullopt;
    const absl::string_view address = host.substr(0, end);
    return IsAddress(AF_INET6, address) ? std::optional(address) : std::nullopt;
  }
  const size_t colon = std::min(host.find(':'), host.size());
  if (!IsPort(host.substr(colon))) return std::nullopt;
  return absl::StripSuffix(host.substr(0, colon), ".");
}

}  // namespace

bool IsOwnHost(absl::string_view host, const std::vector<std::string>& names) {
  if (host.empty()) return true;
  const std::optional<absl::string_view> name = WithoutPort(host);
  const auto is_named = [&name](const std::string& own) {
    return own == kEveryHost || (name && absl::EqualsIgnoreCase(*name, own));
  };
  if (std::any_of(names.begin(), names.end(), is_named)) return true;
  if (!name) return false;
  return IsAddress(AF_INET, *name) || IsAddress(AF_INET6, *name) ||
         absl::EqualsIgnoreCase(*name, "localhost") ||
         absl::EndsWithIgnoreCase(*name, ".localhost");
}

absl::Status CheckHostName(absl::string_view what, absl::string_view name) {
  const auto may_stand = [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '.' || c == '_';
  };
  const bool is_name = !name.empty() && name.size() <= kLongestName &&
                       std::all_of(name.begin(), name.end(), may_stand);
  if (is_name || name == kEveryHost) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(what, " is \"", name,
                   "\", must be a host's name without scheme and port (viewer.lan), or * for all"));
}

}  // namespace corbslam::services
