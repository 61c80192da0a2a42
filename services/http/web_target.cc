#include "services/http/web_target.h"

#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"

namespace corbslam::services {
namespace {

constexpr char kTokenPrefix[] = "token.";

std::vector<absl::string_view> SplitProtocols(absl::string_view protocols) {
  std::vector<absl::string_view> parts = absl::StrSplit(protocols, ',');
  for (absl::string_view& part : parts) part = absl::StripAsciiWhitespace(part);
  return parts;
}

// Returns "/path" of "http://host/path".
absl::string_view WithoutHost(absl::string_view target) {
  const size_t scheme = target.find("://");
  if (absl::StartsWith(target, "/") || scheme == absl::string_view::npos) return target;
  const size_t path = target.find_first_of("/?", scheme + 3);
  return path == absl::string_view::npos ? "/" : target.substr(path);
}

}  // namespace

std::optional<std::string> DecodePercent(absl::string_view text, bool plus_is_space) {
  std::string decoded;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%') {
      if (i + 2 >= text.size() || !absl::ascii_isxdigit(static_cast<unsigned char>(text[i + 1])) ||
          !absl::ascii_isxdigit(static_cast<unsigned char>(text[i + 2]))) {
        return std::nullopt;
      }
      decoded += absl::HexStringToBytes(text.substr(i + 1, 2));
      i += 2;
    } else {
      decoded += text[i] == '+' && plus_is_space ? ' ' : text[i];
    }
  }
  if (absl::StrContains(decoded, '\0')) return std::nullopt;
  return decoded;
}

bool ReadTarget(absl::string_view target, WebRequest& request) {
  target = WithoutHost(target.substr(0, target.find('#')));
  if (!absl::StartsWith(target, "/") && target != "*") return false;
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(target, absl::MaxSplits('?', 1));
  const std::optional<std::string> path = DecodePercent(parts.first, false);
  if (!path) return false;
  request.path = *path;
  for (const absl::string_view field : absl::StrSplit(parts.second, '&', absl::SkipEmpty())) {
    const std::pair<absl::string_view, absl::string_view> entry =
        absl::StrSplit(field, absl::MaxSplits('=', 1));
    const std::optional<std::string> name = DecodePercent(entry.first, true);
    const std::optional<std::string> value = DecodePercent(entry.second, true);
    if (!name || !value) return false;
    request.query[*name] = *value;
  }
  return true;
}

std::string TokenOfProtocols(absl::string_view protocols) {
  for (absl::string_view part : SplitProtocols(protocols)) {
    if (absl::ConsumePrefix(&part, kTokenPrefix)) return std::string(part);
  }
  return "";
}

bool OffersProtocol(absl::string_view protocols, absl::string_view protocol) {
  for (const absl::string_view part : SplitProtocols(protocols)) {
    if (part == protocol) return true;
  }
  return false;
}

bool IsSameOrigin(absl::string_view origin, absl::string_view host) {
  if (origin.empty()) return true;
  const size_t scheme = origin.find("://");
  return scheme != absl::string_view::npos &&
         absl::EqualsIgnoreCase(origin.substr(scheme + 3), host);
}

}  // namespace corbslam::services
