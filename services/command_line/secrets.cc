#include "services/command_line/secrets.h"

#include <regex>

namespace corbslam::services {

std::string HideSecrets(const std::string& text) {
  // Up to the last @ before a slash or a blank: an @ in a password is often not escaped.
  static const std::regex& in_url = *new std::regex(R"((://[^/:\s"']*):[^/\s"']*@)");
  static const std::regex& named = *new std::regex(
      R"(((?:user-pw|password|passwd|passphrase|secret)=)[^\s"'&,;!]+)", std::regex::icase);
  return std::regex_replace(std::regex_replace(text, in_url, "$1:***@"), named, "$1***");
}

}  // namespace corbslam::services
