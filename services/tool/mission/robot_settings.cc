#include "services/tool/mission/robot_settings.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <map>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "client_agent/source/pictures/mask_picture.h"
#include "services/convert/resource_names.h"
#include "services/security/pem_files.h"
#include "services/security/robot_settings_signature.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// A clock that is wrong by more must not use up versions.
constexpr absl::Duration kLongestAhead = absl::Hours(24 * 366);

absl::Status Unset(const std::string& name, v1::RobotSettings& settings) {
  static const auto& clears = *new std::map<std::string, void (v1::RobotSettings::*)()>{
      {"features", &v1::RobotSettings::clear_features},
      {"max-rate", &v1::RobotSettings::clear_max_frame_rate_hz},
      {"memory-budget-mb", &v1::RobotSettings::clear_memory_budget_bytes},
      {"upload", &v1::RobotSettings::clear_upload_features},
      {"share", &v1::RobotSettings::clear_share},
      {"share-radius", &v1::RobotSettings::clear_share_radius_m},
      {"uplink-kbps", &v1::RobotSettings::clear_uplink_kbps},
      {"mask", &v1::RobotSettings::clear_mask_png}};
  const auto clear = clears.find(name);
  if (clear == clears.end()) {
    return absl::InvalidArgumentError(
        absl::StrCat("--unset is ", name,
                     ", must be features, max-rate, memory-budget-mb, upload, "
                     "share, share-radius, uplink-kbps or mask"));
  }
  (settings.*clear->second)();
  return absl::OkStatus();
}

absl::Status PutGiven(const RobotSettingsFlags& flags, v1::RobotSettings& settings) {
  for (const std::string& name : flags.unset) RETURN_IF_ERROR(Unset(name, settings));
  if (flags.features) settings.set_features(*flags.features);
  if (flags.max_rate_hz) settings.set_max_frame_rate_hz(*flags.max_rate_hz);
  if (flags.memory_budget_mb) {
    constexpr uint64_t kMost = std::numeric_limits<uint64_t>::max() >> 20;
    if (*flags.memory_budget_mb > kMost) {
      return absl::InvalidArgumentError(absl::StrCat(
          "--memory-budget-mb is ", *flags.memory_budget_mb, ", must be at most ", kMost));
    }
    settings.set_memory_budget_bytes(*flags.memory_budget_mb << 20);
  }
  if (flags.upload) {
    absl::string_view text = *flags.upload;
    absl::ConsumePrefix(&text, "features=");
    settings.set_upload_features(std::string(text));
  }
  if (flags.share) settings.set_share(*flags.share);
  if (flags.share_radius_m) settings.set_share_radius_m(*flags.share_radius_m);
  if (flags.uplink_kbps) settings.set_uplink_kbps(*flags.uplink_kbps);
  if (!flags.mask) return absl::OkStatus();
  ASSIGN_OR_RETURN(*settings.mutable_mask_png(), ReadSecurityFile("--mask", *flags.mask));
  // What the robot would refuse is not signed.
  RETURN_IF_ERROR(
      client_agent::DecodeMaskPicture("--mask " + *flags.mask, settings.mask_png()).status());
  return absl::OkStatus();
}

// Returns what the new settings begin with: those of before, if this key signed them.
absl::StatusOr<v1::RobotSettings> BeginFrom(const v1::SignedRobotSettings& now,
                                            const std::string& private_key_pem, bool replace) {
  v1::RobotSettings before;
  if (replace) {
    v1::RobotSettings said;
    // What can't be read has no version that counts.
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

// Visits what is set, with the flag's name and its value in words.
void VisitSettings(const v1::RobotSettings& settings,
                   const std::function<void(const char*, const std::string&)>& visit) {
  if (settings.has_features()) visit("features", absl::StrCat(settings.features()));
  if (settings.has_max_frame_rate_hz()) {
    visit("max-rate", absl::StrCat(settings.max_frame_rate_hz()));
  }
  if (settings.has_memory_budget_bytes()) {
    visit("memory-budget-mb", absl::StrCat(settings.memory_budget_bytes() >> 20));
  }
  if (settings.has_upload_features()) {
    visit("upload", absl::StrCat("features=", absl::CHexEscape(settings.upload_features())));
  }
  if (settings.has_share()) visit("share", absl::CHexEscape(settings.share()));
  if (settings.has_share_radius_m()) visit("share-radius", absl::StrCat(settings.share_radius_m()));
  if (settings.has_uplink_kbps()) visit("uplink-kbps", absl::StrCat(settings.uplink_kbps()));
  if (settings.has_mask_png()) {
    visit("mask", absl::StrCat(settings.mask_png().size(), " bytes of PNG"));
  }
}

}  // namespace

bool IsEmpty(const RobotSettingsFlags& flags) {
  return !flags.features && !flags.max_rate_hz && !flags.memory_budget_mb && !flags.upload &&
         !flags.share && !flags.share_radius_m && !flags.uplink_kbps && !flags.mask &&
         flags.unset.empty() && !flags.replace;
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
