#include "services/tool/mission/robot_settings.h"

#include <algorithm>
#include <cstdint>
#include <functional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/strip.h"
#include "client_agent/source/pictures/mask_picture.h"
#include "services/command_line/setting.h"
#include "services/convert/resource_names.h"
#include "services/security/pem_files.h"
#include "services/security/robot_settings_signature.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

namespace {

// A clock that is wrong by more must not use up versions.
constexpr absl::Duration kLongestAhead = absl::Hours(24 * 366);

std::string ToolFlags() {
  std::vector<std::string> flags;
  for (const RobotSetting& row : RobotSettingTable()) flags.emplace_back(row.tool_flag);
  return absl::StrJoin(flags, ", ");
}

absl::Status Unset(const std::string& name, v1::RobotSettings& settings) {
  for (const RobotSetting& row : RobotSettingTable()) {
    if (row.tool_flag != name) continue;
    ClearSetting(row, settings);
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("--unset is ", name, ", must be one of ", ToolFlags()));
}

// Reads the file, and says whether a robot would take it.
absl::Status PutMask(const std::string& file, v1::RobotSettings& settings) {
  ASSIGN_OR_RETURN(*settings.mutable_mask_png(), ReadSecurityFile("--mask", file));
  return client_agent::DecodeMaskPicture("--mask " + file, settings.mask_png()).status();
}

absl::Status PutGiven(const RobotSettingsFlags& flags, v1::RobotSettings& settings) {
  for (const std::string& name : flags.unset) RETURN_IF_ERROR(Unset(name, settings));
  for (const RobotSetting& row : RobotSettingTable()) {
    const auto text = flags.given.find(row.tool_flag);
    if (text == flags.given.end()) continue;
    if (row.is_file) {
      RETURN_IF_ERROR(PutMask(text->second, settings));
      continue;
    }
    const std::string wrong = PutSetting(row, text->second, settings);
    if (wrong.empty()) continue;
    return absl::InvalidArgumentError(absl::StrCat("--", row.tool_flag, " ", wrong));
  }
  return absl::OkStatus();
}

// Returns what the new settings begin with: those of before, if this key signed them.
absl::StatusOr<v1::RobotSettings> BeginFrom(const v1::SignedRobotSettings& now,
                                            const std::string& private_key_pem, bool replace) {
  v1::RobotSettings before;
  if (replace) {
    v1::RobotSettings said;
    // Settings that can't be read count as version 0.
    if (said.ParseFromString(now.settings())) before.set_version(said.version());
    return before;
  }
  ASSIGN_OR_RETURN(const Ed25519Key key, ReadEd25519PrivateKey(private_key_pem));
  absl::StatusOr<v1::RobotSettings> verified = VerifyRobotSettings(now, {key});
  if (verified.ok()) return verified;
  return absl::PermissionDeniedError(
      absl::StrCat("the map store's settings are not taken over: ", verified.status().message(),
                   ": sign with the key that signed them, or say all of them anew with --replace"));
}

absl::StatusOr<uint64_t> VersionAfter(uint64_t last, absl::Time time) {
  const auto now_s = static_cast<uint64_t>(std::max<int64_t>(1, absl::ToUnixSeconds(time)));
  if (last <= now_s + static_cast<uint64_t>(absl::ToInt64Seconds(kLongestAhead))) {
    return std::max(last + 1, now_s);
  }
  return absl::FailedPreconditionError(
      absl::StrCat("the last version is ", last, ", more than a year ahead of this clock (", now_s,
                   "): versions are seconds since 1970; set the clock right"));
}

// Visits what is set, with the flag's name and its value as text.
void VisitSettings(const v1::RobotSettings& settings,
                   const std::function<void(const char*, const std::string&)>& visit) {
  for (const RobotSetting& row : RobotSettingTable()) {
    if (!HasSetting(row, settings)) continue;
    visit(row.tool_flag, SettingText(row, settings, row.tool_unit));
  }
}

}  // namespace

std::string PutSetting(const RobotSetting& row, const std::string& text,
                       v1::RobotSettings& settings) {
  if (row.wanted != nullptr) {
    const std::string value(absl::StripPrefix(text, row.prefix));
    const std::string wanted = row.wanted(value);
    SetText(row, value, settings);
    return wanted.empty() ? "" : absl::StrCat("is \"", text, "\", must be ", row.prefix, wanted);
  }
  const auto unit = static_cast<double>(row.tool_unit);
  const NumberRange in = {row.in.least / unit, row.in.most / unit, row.in.zero};
  uint64_t integer = 0;
  double real = 0;
  std::string wrong = IsInteger(row) ? ReadSetting({row.tool_flag, &integer, "", {.in = in}}, text)
                                     : ReadSetting({row.tool_flag, &real, "", {.in = in}}, text);
  SetNumber(row, unit * (IsInteger(row) ? static_cast<double>(integer) : real), settings);
  return wrong;
}

bool IsEmpty(const RobotSettingsFlags& flags) {
  return flags.given.empty() && flags.unset.empty() && !flags.replace;
}

const v1::SignedRobotSettings* FindSettings(const v1::RobotSettingsList& list,
                                            const std::string& agent) {
  for (const v1::SignedRobotSettings& entry : list.settings()) {
    v1::RobotSettings settings;
    if (settings.ParseFromString(entry.settings()) && settings.agent() == agent) return &entry;
  }
  return nullptr;
}

absl::StatusOr<v1::SignedRobotSettings> MakeSettings(
    const RobotSettingsFlags& flags, const std::string& mission, const std::string& agent,
    const v1::SignedRobotSettings* now, const std::string& private_key_pem, absl::Time time) {
  v1::RobotSettings settings;
  if (now != nullptr) {
    ASSIGN_OR_RETURN(settings, BeginFrom(*now, private_key_pem, flags.replace));
  }
  settings.set_mission(MissionName(mission));
  settings.set_agent(agent);
  ASSIGN_OR_RETURN(const uint64_t version, VersionAfter(settings.version(), time));
  settings.set_version(version);
  RETURN_IF_ERROR(PutGiven(flags, settings));
  return SignRobotSettings(settings, private_key_pem);
}

std::string FormatSettings(const v1::RobotSettingsList& list) {
  std::string text;
  for (const v1::SignedRobotSettings& entry : list.settings()) {
    v1::RobotSettings settings;
    if (!settings.ParseFromString(entry.settings())) continue;
    absl::StrAppend(&text, settings.agent().empty() ? "all robots" : settings.agent(), ", version ",
                    settings.version(), "\n");
    VisitSettings(settings, [&text](const char* name, const std::string& value) {
      absl::StrAppend(&text, "  ", name, ": ", value, "\n");
    });
  }
  return text;
}

nlohmann::ordered_json ToJson(const v1::RobotSettingsList& list) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const v1::SignedRobotSettings& entry : list.settings()) {
    v1::RobotSettings settings;
    if (!settings.ParseFromString(entry.settings())) continue;
    nlohmann::ordered_json set = nlohmann::ordered_json::object();
    VisitSettings(settings,
                  [&set](const char* name, const std::string& value) { set[name] = value; });
    json.push_back(
        {{"agent", settings.agent()}, {"version", settings.version()}, {"settings", set}});
  }
  return json;
}

}  // namespace corbslam::services
