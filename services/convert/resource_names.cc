#include "services/convert/resource_names.h"

#include <charconv>
#include <optional>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr size_t kMaxSegment = 63;
constexpr size_t kIdDigits = 16;

absl::Status BadName(absl::string_view name, absl::string_view form) {
  return absl::InvalidArgumentError(
      absl::StrCat("name is \"", absl::CHexEscape(name.substr(0, 200)), "\", must be ", form));
}

// Returns the variable segments of "missions/{}/agents/{}" and the like.
absl::StatusOr<std::vector<absl::string_view>> ParsePath(
    absl::string_view name, const std::vector<absl::string_view>& collections,
    absl::string_view form) {
  const std::vector<absl::string_view> segments = absl::StrSplit(name, '/');
  if (segments.size() != 2 * collections.size()) return BadName(name, form);
  std::vector<absl::string_view> values;
  for (size_t i = 0; i < collections.size(); ++i) {
    if (segments[2 * i] != collections[i]) return BadName(name, form);
    values.push_back(segments[2 * i + 1]);
  }
  RETURN_IF_ERROR(CheckNameSegment("mission", values[0]));
  return values;
}

template <typename Number>
std::optional<Number> ParseNumber(absl::string_view text, int base) {
  Number number = 0;
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number, base);
  if (text.empty() || error != std::errc() || at != end) return std::nullopt;
  return number;
}

std::optional<LocalMapId> ParseId(absl::string_view text) {
  if (text.size() != kIdDigits) return std::nullopt;
  const auto value = ParseNumber<uint64_t>(text, 16);
  if (!value || *value == 0) return std::nullopt;
  return LocalMapId{*value};
}

}  // namespace

std::string MissionName(absl::string_view mission) { return absl::StrCat("missions/", mission); }

std::string AgentName(absl::string_view mission, absl::string_view agent) {
  return absl::StrCat("missions/", mission, "/agents/", agent);
}

std::string LocalMapName(absl::string_view mission, LocalMapId local_map) {
  return absl::StrCat("missions/", mission, "/localMaps/", ToString(local_map));
}

std::string KeyframeName(absl::string_view mission, KeyframeId keyframe) {
  return absl::StrCat(LocalMapName(mission, keyframe.local_map), "/keyframes/", keyframe.index);
}

std::string OverlapName(absl::string_view mission, uint64_t overlap) {
  return absl::StrCat("missions/", mission, "/overlaps/", overlap);
}

std::string BackupName(absl::string_view mission, uint32_t number) {
  return absl::StrCat("missions/", mission, "/backups/", number);
}

std::string LastSegment(const std::string& name) { return name.substr(name.rfind('/') + 1); }

absl::Status CheckNameSegment(absl::string_view field, absl::string_view segment) {
  const auto fits = [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '_';
  };
  bool good = !segment.empty() && segment.size() <= kMaxSegment &&
              absl::ascii_isalnum(static_cast<unsigned char>(segment.front()));
  for (const char c : segment) good = good && fits(c);
  if (good) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      field, " is \"", absl::CHexEscape(segment.substr(0, 100)), "\", must be 1 to ", kMaxSegment,
      " letters, digits, dots, dashes and underscores, beginning with a letter or digit"));
}

absl::StatusOr<std::string> ParseMissionName(absl::string_view name) {
  ASSIGN_OR_RETURN(const auto values, ParsePath(name, {"missions"}, "missions/{mission}"));
  return std::string(values[0]);
}

absl::StatusOr<AgentPath> ParseAgentName(absl::string_view name, bool may_be_all) {
  ASSIGN_OR_RETURN(const auto values,
                   ParsePath(name, {"missions", "agents"}, "missions/{mission}/agents/{agent}"));
  AgentPath path{.mission = std::string(values[0]), .agent = {}};
  if (may_be_all && values[1] == "-") return path;
  RETURN_IF_ERROR(CheckNameSegment("agent", values[1]));
  path.agent = std::string(values[1]);
  return path;
}

absl::StatusOr<LocalMapPath> ParseLocalMapName(absl::string_view name, bool may_be_all) {
  constexpr absl::string_view kForm = "missions/{mission}/localMaps/{16 hexadecimal digits}";
  ASSIGN_OR_RETURN(const auto values, ParsePath(name, {"missions", "localMaps"}, kForm));
  LocalMapPath path{.mission = std::string(values[0]), .local_map = {}};
  if (may_be_all && values[1] == "-") return path;
  const std::optional<LocalMapId> id = ParseId(values[1]);
  if (!id) return BadName(name, kForm);
  path.local_map = *id;
  return path;
}

absl::StatusOr<KeyframePath> ParseKeyframeName(absl::string_view name) {
  constexpr absl::string_view kForm =
      "missions/{mission}/localMaps/{16 hexadecimal digits}/keyframes/{index}";
  ASSIGN_OR_RETURN(const auto values,
                   ParsePath(name, {"missions", "localMaps", "keyframes"}, kForm));
  const std::optional<LocalMapId> id = ParseId(values[1]);
  const auto index = ParseNumber<uint32_t>(values[2], 10);
  if (!id || !index || *index == KeyframeId::kNoIndex) return BadName(name, kForm);
  return KeyframePath{std::string(values[0]), {*id, *index}};
}

absl::StatusOr<OverlapPath> ParseOverlapName(absl::string_view name) {
  constexpr absl::string_view kForm = "missions/{mission}/overlaps/{number}";
  ASSIGN_OR_RETURN(const auto values, ParsePath(name, {"missions", "overlaps"}, kForm));
  const auto number = ParseNumber<uint64_t>(values[1], 10);
  if (!number) return BadName(name, kForm);
  return OverlapPath{std::string(values[0]), *number};
}

absl::StatusOr<BackupPath> ParseBackupName(absl::string_view name) {
  constexpr absl::string_view kForm = "missions/{mission}/backups/{number}";
  ASSIGN_OR_RETURN(const auto values, ParsePath(name, {"missions", "backups"}, kForm));
  const auto number = ParseNumber<uint32_t>(values[1], 10);
  if (!number || *number == 0) return BadName(name, kForm);
  return BackupPath{std::string(values[0]), *number};
}

}  // namespace corbslam::services
