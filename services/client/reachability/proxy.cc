#include "services/client/reachability/proxy.h"

#include <cstdlib>
#include <initializer_list>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"

namespace corbslam::services {
namespace {

constexpr absl::string_view kScheme = "http://";

// Returns the value of the first variable that is set, even if it is empty, and its name.
const char* FirstSet(const ReadVariable& read, std::initializer_list<const char*> names,
                     std::string& name) {
  for (const char* candidate : names) {
    const char* value = read(candidate);
    if (value == nullptr) continue;
    name = candidate;
    return value;
  }
  return nullptr;
}

// Returns true if the list of exceptions covers the host: "robot.lan" is covered by ".lan" and by
// "lan"; blanks are part of an entry.
bool IsExcepted(absl::string_view host, const ReadVariable& read) {
  std::string name;
  const char* list = FirstSet(read, {"no_grpc_proxy", "no_proxy"}, name);
  if (list == nullptr) return false;
  for (const absl::string_view entry : absl::StrSplit(list, ',', absl::SkipEmpty())) {
    if (absl::EndsWithIgnoreCase(host, entry)) return true;
  }
  return false;
}

}  // namespace

std::optional<Proxy> FindProxy(const std::string& host, const ReadVariable& read) {
  Proxy proxy;
  const char* value = FirstSet(read, {"grpc_proxy", "https_proxy", "http_proxy"}, proxy.variable);
  // gRPC knows no other scheme, and goes without a proxy then.
  if (value == nullptr || !absl::StartsWith(value, kScheme) || IsExcepted(host, read)) {
    return std::nullopt;
  }
  absl::string_view rest = absl::StripPrefix(value, kScheme);
  rest = rest.substr(0, rest.find('/'));
  const size_t at = rest.rfind('@');
  if (at != absl::string_view::npos) rest.remove_prefix(at + 1);
  proxy.url = absl::StrCat(kScheme, at == absl::string_view::npos ? "" : "...@", rest);
  const absl::StatusOr<HostPort> address = ParseServerAddress(rest);
  if (address.ok()) proxy.address = *address;
  return proxy;
}

std::optional<Proxy> FindProxy(const std::string& host) {
  return FindProxy(host, [](const char* name) -> const char* { return std::getenv(name); });
}

}  // namespace corbslam::services
