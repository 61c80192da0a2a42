#include "services/command_line/secrets.h"

#include <regex>

#include "absl/strings/str_cat.h"

namespace corbslam::services {
namespace {

// The matcher's stack grows with the text.
constexpr size_t kLongest = 4096;

}  // namespace

std::string HideSecrets(const std::string& text) {
  if (text.size() > kLongest) return absl::StrCat("*** (", text.size(), " characters)");
  // Up to the last @ before a slash or a blank: an @ in a password is often not escaped.
  static const std::regex& in_url = *new std::regex(R"((://[^/:\s"']*):[^/\s"']*@)");
  static const std::regex& named = *new std::regex(
      R"(((?:user-pw|password|passwd|passphrase|secret)=)[^\s"'&,;!]+)", std::regex::icase);
  return std::regex_replace(std::regex_replace(text, in_url, "$1:***@"), named, "$1***");
}

}  // namespace corbslam::services
