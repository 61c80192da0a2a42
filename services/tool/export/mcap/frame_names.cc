#include "services/tool/export/mcap/frame_names.h"

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace corbslam::services {
namespace {

template <typename IsKept>
std::string Escape(absl::string_view text, const IsKept& is_kept) {
  std::string escaped;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (is_kept(byte)) {
      escaped.push_back(c);
    } else {
      absl::StrAppendFormat(&escaped, "%%%02X", byte);
    }
  }
  return escaped;
}

}  // namespace

std::string EscapeName(absl::string_view name) {
  if (name.empty()) return "%";
  return Escape(name, [](unsigned char byte) {
    return absl::ascii_isalnum(byte) || byte == '.' || byte == '-' || byte == '_';
  });
}

std::string EscapeText(absl::string_view text) {
  return Escape(text, [](unsigned char byte) { return absl::ascii_isprint(byte); });
}

std::string IslandFrame(LocalMapId island) { return absl::StrCat("island/", ToString(island)); }

std::string MapTopic(absl::string_view robot, absl::string_view what) {
  return absl::StrCat("/map/", EscapeName(robot), "/", what);
}

std::string RobotTopic(absl::string_view robot, absl::string_view what) {
  return absl::StrCat("/robots/", EscapeName(robot), "/", what);
}

std::string NumberSuffix(size_t number) { return number <= 1 ? "" : absl::StrCat("+", number); }

std::string IslandSuffix(LocalMapId island, bool in_global_frame) {
  return in_global_frame ? "" : absl::StrCat("/", ToString(island));
}

}  // namespace corbslam::services
